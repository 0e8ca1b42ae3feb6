// The page of a study is whole, well-formed, escaped, and says what is missing.

#include "piste/report/study_page.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <cstdlib>
#include <fstream>

#include "piste/files/study.h"
#include "piste/report/study_figures.h"
#include "piste/report/study_text.h"
#include "report/well_formed.h"
#include "support/article.h"
#include "support/study_case.h"
#include "support/text_file.h"

namespace piste {
namespace {

using test::contains;
using test::StudyCase;

std::string page_of(const Study& study) {
  const std::string page = study_html(study, "0.1.0", "runs: [<a>]\n</pre><script>");
  EXPECT_EQ(test::not_well_formed(test::body_of(page)), "");
  const std::string own = test::without_libraries(page), body = test::body_of(page);
  for (const char* wrong : {"src=", "<link", "href=\"http", "@import", "url(", ">nan", "nan ", "inf<", ">inf"}) {
    EXPECT_EQ(own.find(wrong), std::string::npos) << wrong << ": " << own.substr(own.find(wrong) - 80, 160);
  }
  for (const char* wrong : {"<script", "e-0"}) EXPECT_EQ(body.find(wrong), std::string::npos) << wrong;
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
  study.article = test::bonnaz_2008();
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
  EXPECT_TRUE(contains(page, ">article, Table 1</th><th scope=\"col\" class=\"number\">its std</th>"));
  EXPECT_TRUE(contains(page, "J.-M. Bonnaz, Évaluation du modèle"));
  const std::string fourth = page.substr(page.find("MT-9A 4 fx</th><td"), 2000);
  EXPECT_TRUE(contains(fourth.substr(0, fourth.find("</tr>")), "></td><td class=\"number\"></td>"))
      << "the article has no such sensor";
}

TEST(StudyPage, SaysWhatTheArticleImplies) {
  Study empty;
  empty.article = test::bonnaz_2008();
  const std::string page = page_of(empty);
  for (const char* part :
       {"the mean force is (−6.54, −0.19, −7.19) m/s², 9.72 m/s² long", "−6.93 to −6.14", "16 of 18", "0.00066",
        "The article calls a number significant", "make up to 0.173 m/s² of the mean force",
        "standard deviations of wx and wy are the same on every sensor"}) {
    EXPECT_TRUE(contains(page, part)) << part;
  }
  Study study = StudyCase{}.study();
  study.article = test::bonnaz_2008();
  EXPECT_TRUE(contains(page_of(study), "delay needed [ms]"));
  EXPECT_TRUE(contains(page_of(study), "wx in the article"));
}

// All that a study writes, in small letters.
std::string everything(const Study& study) {
  std::string all = page_of(study) + study_json(study) + study_text(study);
  for (const StudyFile& file : study_csv(study)) all += file.name + file.content;
  for (const Figure& figure : study_figures(study)) all += figure.name + figure.svg + figure.caption;
  for (char& c : all) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return all;
}

TEST(StudyPage, SaysNothingOfAnArticleThatNobodyNamed) {
  const std::string all = everything(StudyCase{}.study());
  const auto found = all.find("article");
  EXPECT_EQ(found, std::string::npos) << all.substr(found - 80, 160);
  EXPECT_FALSE(contains(all, "bonnaz"));
}

TEST(StudyPage, GivesSensorsOfOtherNamesNoColumnsOfTheArticle) {
  Study study = StudyCase{}.study();
  study.article = test::bonnaz_2008();
  for (std::string& name : study.sensors) name += " of mine";
  const std::string page = page_of(study);
  EXPECT_TRUE(contains(page, "What the article's numbers imply"));
  EXPECT_FALSE(contains(page, ">article, Table")) << "no sensor has a counterpart";
  EXPECT_FALSE(contains(page, "its std"));
}

TEST(StudyPage, DoesWithAnArticleOfOneTable) {
  Study study = StudyCase{}.study();
  study.article = test::bonnaz_2008();
  CampaignTables& tables = study.article->article.tables;
  const PrintedTable rest = tables.rest;
  for (PrintedTable* table : {&tables.before, &tables.after, &tables.joint_bias, &tables.joint_scale,
                              &tables.correlation, &tables.bias_only}) {
    for (PrintedRow& row : table->sensors) row.fill({});
  }
  const std::string page = page_of(study);
  EXPECT_TRUE(contains(page, ">article, Table 1</th>"));
  EXPECT_FALSE(contains(page, ">article, Table 3</th>"));
  EXPECT_TRUE(contains(page, "Table 1, the article"));
  EXPECT_FALSE(contains(page, "Table 6, the article"));
}

// Replays with the rest before are `factor` times as wrong as with kMarkovSmoothed, and a little more or less by turns.
Study study_with(double factor, double scatter) {
  Study study = StudyCase{}.study();
  for (SensorRun& r : study.results) {
    const auto of = [&r](Method m) { return std::ranges::find(r.scores, m, &NavigationScore::method); };
    const double more = factor * std::exp(r.run % 2 == 0 ? scatter : -scatter);
    NavigationScore rest = *of(Method::kMarkovSmoothed);
    for (double* error : {&rest.position_rmse, &rest.velocity_rmse, &rest.attitude_rmse, &rest.outage_drift}) {
      *error *= more;
    }
    rest.method = Method::kRest;
    *of(Method::kRest) = rest;
  }
  return study;
}

TEST(StudyPage, NamesNoWinnerWhereMethodsTie) {
  // Not significant: 3 % with a scatter of 10 %; and significant, but 1.00 in print.
  for (const Study& study : {study_with(1.03, 0.1), study_with(1.002, 1e-5)}) {
    const std::string page = page_of(study);
    EXPECT_TRUE(contains(page,
                         "<strong>2 methods tie for the best navigation</strong>: “Gauss-Markov, smoothed” and "
                         "“rest before”."));
    EXPECT_TRUE(contains(page, "Gauss-Markov, smoothed (tie)"));
    EXPECT_TRUE(contains(page, "rest before (tie)"));
    EXPECT_TRUE(contains(page, "“Gauss-Markov, smoothed” has the lowest score in "));
    EXPECT_FALSE(contains(page, "winner"));
    EXPECT_FALSE(contains(page, "The best navigation comes from"));
  }
  const std::string page = page_of(study_with(1.02, 1e-5));
  EXPECT_TRUE(contains(page, "The best navigation comes from “Gauss-Markov, smoothed”"));
  EXPECT_TRUE(contains(page, "Next is “rest before”, with 1.02 times the errors of the winner"));
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
