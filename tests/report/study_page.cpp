// The page of a study is whole, well-formed, escaped, and says what is missing.

#include "piste/report/study_page.h"

#include <gtest/gtest.h>

#include <cstdlib>
#include <fstream>

#include "report/well_formed.h"
#include "support/study_case.h"
#include "support/text_file.h"

namespace piste {
namespace {

using test::contains;
using test::StudyCase;

std::string page_of(const Study& study) {
  const std::string page = study_html(study, "0.1.0", "runs: [<a>]\n</pre><script>");
  const std::size_t from = page.find("<main>"), to = page.find("</body>");
  EXPECT_EQ(test::not_well_formed(page.substr(from, to - from)), "");
  for (const char* wrong :
       {"src=", "<link", "href=\"http", "@import", "url(", "<script", ">nan", "nan ", "inf<", ">inf", "e-0"}) {
    EXPECT_EQ(page.find(wrong), std::string::npos) << wrong << ": " << page.substr(page.find(wrong) - 80, 160);
  }
  EXPECT_FALSE(contains(page, "<td class=\"number\">-")) << "a minus is a real one";
  return page;
}

TEST(StudyPage, TellsEverythingInOneFile) {
  const std::string page = page_of(StudyCase{.failed = true}.study());
  for (const char* part : {"<title>nine &lt;runs&gt; &amp; more</title>",
                           "piste 0.1.0 · 3 IMUs in 9 runs · both signals below 12 Hz · simulated",
                           "The best navigation comes from “Gauss-Markov, smoothed”",
                           "Next is “rest before”",
                           "Every other method is significantly worse.",
                           "of 10 000 resamplings of the 9 runs",
                           "For comparison, over the winner: “nothing known”",
                           "(correlation above 0.9): fx of 3 of 3 sensors, fz of 3 of 3 sensors.",
                           "Table 1. Biases at rest before the start",
                           "Table 2. Biases at rest",
                           "Table 3. Biases in the run, with scales",
                           "Table 4. Scales in the run",
                           "Table 5. Correlation",
                           "Table 6. Biases in the run, without scales",
                           "Biases by Gauss-Markov",
                           "Table 7. Navigation",
                           "std between runs",
                           "error within a run",
                           "formal",
                           "p, Holm",
                           "Gauss-Markov, smoothed (winner)",
                           "Correlation of bias and scale in the run",
                           "Bias&#39; of the accelerometers",
                           "Scale&#39; of the gyroscopes",
                           "Truth inside the 95 % interval",
                           "What the article's numbers imply",
                           "bicycle-9, MT-9A 3: mt9a_3.csv:1: no sample",
                           "ski-1, MT-9A 1: the plate flexes by 0.2°",
                           "How to read it",
                           "runs: [&lt;a&gt;]\n&lt;/pre&gt;&lt;script&gt;"}) {
    EXPECT_TRUE(contains(page, part)) << part;
  }
  EXPECT_LT(page.size(), 1'000'000U);
  // PISTE_SHOW=FILE keeps the page to be looked at.
  if (const char* file = std::getenv("PISTE_SHOW")) std::ofstream(file) << page;
}

TEST(StudyPage, PutsTheArticleBesideOurNumbers) {
  Study study = StudyCase{.runs = 3, .sensors = 4}.study();
  for (SensorRun& r : study.results) {
    for (MethodEstimate& e : r.estimates) {
      if (e.method != Method::kRest) continue;
      e.axes[0].bias_alone = Term{0.125 + 0.01 * static_cast<double>(r.run), 1e-4, 2e-3, 30, 0};
      e.axes[0].true_bias = 0.13;
    }
  }
  const std::string page = page_of(study);
  // Correction of 0.125, 0.135, 0.145: −0.135, spread 0.01, of the mean 0.0058; the truth; the article's own.
  const std::string row = page.substr(page.find("MT-9A 1 fx</th><td"), 500);
  for (const char* cell :
       {">−0.1350<", ">0.010<", ">0.0058<", ">0.0020<", ">0.00010<", ">−0.1300<", ">0.034<", ">0.020<"}) {
    EXPECT_TRUE(contains(row, cell)) << cell << row;
  }
  EXPECT_TRUE(contains(page, "MT-9A 4 fx")) << "a sensor that the article does not have";
}

TEST(StudyPage, SaysWhatTheArticleImplies) {
  const std::string page = page_of(Study{});
  for (const char* part : {"the mean force is (−6.54, −0.19, −7.19) m/s², 9.72 m/s² long", "−6.93 to −6.14", "16 of 18",
                           "0.00066", "by its own rule 15 of 18 are", "make up to 0.173 m/s² of the mean force",
                           "standard deviations of wx and wy are the same on every sensor"}) {
    EXPECT_TRUE(contains(page, part)) << part;
  }
  EXPECT_TRUE(contains(page_of(StudyCase{}.study()), "delay needed [ms]"));
}

TEST(StudyPage, DoesWithoutTruth) {
  const std::string page = page_of(StudyCase{.simulated = false}.study());
  EXPECT_TRUE(contains(page, "recorded: the truth is not known"));
  for (const char* part : {"Against the truth", "put in", "Truth inside"}) EXPECT_FALSE(contains(page, part)) << part;
}

TEST(StudyPage, DoesWithLittleOrNothing) {
  const std::string empty = page_of(Study{});
  EXPECT_TRUE(contains(empty, "The methods are not ranked."));
  EXPECT_TRUE(contains(empty, "There is no run."));
  EXPECT_TRUE(contains(empty, "There is nothing to show."));
  const std::string one = page_of(StudyCase{.runs = 1}.study());
  EXPECT_TRUE(contains(one, "3 IMUs in 1 run ·"));
  EXPECT_TRUE(contains(one, "One run cannot say how sure that is."));
  const std::string failed = page_of(StudyCase{.runs = 1, .sensors = 1, .failed = true}.study());
  EXPECT_TRUE(contains(failed, "mt9a_3.csv:1: no sample"));
}

}  // namespace
}  // namespace piste
