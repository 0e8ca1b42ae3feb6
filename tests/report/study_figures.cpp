// Every figure of a study says what it shows, in which unit, and what its bars are.

#include "piste/report/study_figures.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <fstream>
#include <set>
#include <sstream>

#include "report/well_formed.h"
#include "support/study_case.h"
#include "support/text_file.h"

namespace piste {
namespace {

using test::contains;
using test::StudyCase;

std::set<std::string> names_of(const std::vector<Figure>& figures) {
  std::set<std::string> out;
  for (const Figure& f : figures) out.insert(f.name);
  return out;
}

const Figure& named(const std::vector<Figure>& figures, const std::string& name) {
  const auto found = std::ranges::find(figures, name, &Figure::name);
  EXPECT_NE(found, figures.end()) << name;
  return *found;
}

void expect_sound(const std::vector<Figure>& figures) {
  for (const Figure& f : figures) {
    EXPECT_EQ(test::not_well_formed(f.svg), "") << f.name;
    EXPECT_EQ(f.svg.rfind("<svg xmlns=\"http://www.w3.org/2000/svg\"", 0), 0U) << f.name;
    EXPECT_GT(f.caption.size(), 40U) << f.name;
    EXPECT_TRUE(f.name == "table_5" || contains(f.svg, "]</text>")) << f.name << ": an axis has its unit";
    for (const char* wrong : {"nan", "inf<", ">-", ">inf"}) EXPECT_FALSE(contains(f.svg, wrong)) << f.name << wrong;
  }
  EXPECT_EQ(names_of(figures).size(), figures.size());
}

TEST(StudyFigures, AreThoseOfTheArticleAndMore) {
  const auto figures = study_figures(StudyCase{.failed = true}.study());
  expect_sound(figures);
  EXPECT_EQ(names_of(figures),
            (std::set<std::string>{"figure_07_accel", "figure_07_gyro",    "figure_08_accel",  "figure_08_gyro",
                                   "figure_09_accel", "figure_09_gyro",    "figure_10_accel",  "figure_10_gyro",
                                   "figure_13",       "figure_14",         "figure_15_accel",  "figure_15_gyro",
                                   "figure_16",       "figure_17",         "table_5",          "truth_bias_accel",
                                   "truth_bias_gyro", "truth_scale_accel", "truth_scale_gyro", "timing_accel",
                                   "timing_gyro",     "ranking",           "ranking_metrics"}));
  // PISTE_SHOW=FOLDER keeps them to be looked at.
  if (const char* folder = std::getenv("PISTE_SHOW")) {
    for (const Figure& f : figures) std::ofstream(std::string(folder) + "/" + f.name + ".svg") << f.svg;
  }
}

TEST(StudyFigures, SayWhatTheirBarsAre) {
  const auto figures = study_figures(StudyCase{.failed = true}.study());
  for (const char* name : {"figure_08_accel", "figure_13", "figure_14", "figure_15_gyro", "figure_16", "figure_17"}) {
    const std::string& caption = named(figures, name).caption;
    EXPECT_TRUE(contains(caption, "95 % interval of the mean over 8 to 9 runs, by the standard error between runs"))
        << name << caption;
    EXPECT_TRUE(contains(caption, "a correction to add")) << name;
    EXPECT_TRUE(contains(caption, "what was put in")) << name;
  }
  EXPECT_TRUE(contains(named(figures, "timing_accel").caption, "one standard error between runs"));
  EXPECT_TRUE(contains(named(figures, "ranking").caption, "95 % interval of the ratio to the lowest score"));
}

TEST(StudyFigures, OfOneRunKnowTheErrorWithinIt) {
  const auto figures = study_figures(StudyCase{.runs = 1}.study());
  expect_sound(figures);
  EXPECT_TRUE(contains(named(figures, "figure_13").caption, "95 % interval of one run, by the error within it"));
}

TEST(StudyFigures, ShowTheNumbers) {
  Study study = StudyCase{.runs = 2, .sensors = 1}.study();
  for (SensorRun& r : study.results) {
    for (MethodEstimate& e : r.estimates) {
      if (e.method == Method::kRest) e.axes[0].bias_alone = Term{-0.25, 0, 0, 1, 0};
      if (e.method == Method::kRest) e.axes[1].bias_alone = e.axes[2].bias_alone = Term{0.25, 0, 0, 1, 0};
      for (AxisEstimate& axis : e.axes) axis.true_bias.reset();
    }
  }
  const auto figures = study_estimates(study);
  // fx is 0.25 in the article's sign and stands above fy, −0.25, each in the middle of its third of 76 to 962.
  const std::string& svg = named(figures, "figure_08_accel").svg;
  EXPECT_TRUE(contains(svg, "M223.7 48.4h0M519.0 257.6h0M814.3 257.6h0")) << svg;
}

TEST(StudyFigures, MeansAtRestStandOutFromTheirCurves) {
  const auto figures = study_figures(StudyCase{}.study());
  for (const char* name : {"figure_09_accel", "figure_10_gyro"}) {
    const std::string& svg = named(figures, name).svg;
    std::size_t means = 0;
    std::istringstream lines(svg);
    for (std::string line; std::getline(lines, line);) {
      if (line.starts_with("<path class=\"line\"") && contains(line, "stroke-dasharray")) {
        ++means;
        EXPECT_TRUE(contains(line, "stroke=\"var(--ink)\"")) << line;
      }
    }
    EXPECT_EQ(means, 3U) << name;
    EXPECT_TRUE(contains(svg, ">mean</text>")) << name;
  }
}

TEST(StudyFigures, DoWithoutTruthAndWithoutAnything) {
  const auto recorded = study_figures(StudyCase{.simulated = false}.study());
  expect_sound(recorded);
  for (const Figure& f : recorded) {
    EXPECT_EQ(f.name.rfind("truth", 0), std::string::npos);
    EXPECT_FALSE(contains(f.svg, "put in")) << f.name;
    EXPECT_FALSE(contains(f.caption, "put in")) << f.name;
  }
  EXPECT_TRUE(study_figures(Study{}).empty());
  Study failed = StudyCase{.runs = 1, .sensors = 1, .failed = true}.study();
  EXPECT_TRUE(study_figures(failed).empty());
}

}  // namespace
}  // namespace piste
