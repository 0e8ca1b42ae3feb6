// The numbers of a report as text, and the sentence on an ensemble.

#include "consistency/report_numbers.h"

#include <gtest/gtest.h>

#include <cstddef>
#include <string>
#include <vector>

#include "support/ensemble.h"
#include "support/text_file.h"

namespace piste::test {
namespace {

constexpr auto kUnderWay = static_cast<std::size_t>(Phase::kUnderWay);

/// A report of an estimator that saw position and velocity under way.
ConsistencyReport small_report() {
  ConsistencyReport report;
  report.runs = 20;
  report.probability = 0.999;
  report.layout = StateLayout(std::vector<Block>{});
  report.groups = {{"whole", {0, 1}}, {"position", {0}}};
  for (EstimatorConsistency* e : {&report.filter, &report.smoother}) {
    e->groups[kUnderWay] = {{.nees = 1.01, .test = {}}, {.nees = 1.5, .test = {.p_value = 1e-5, .holds = false}}};
    e->blocks[kUnderWay] = {{.ratio = 1.25}, {.ratio = 0.5}};
  }
  return report;
}

TEST(ReportNumbers, AStarIsAtAMeanWhoseTestFails) {
  const ConsistencyReport report = small_report();
  EXPECT_EQ(starred(0.9876, {}), "0.988");
  EXPECT_EQ(nees_text(report.filter, 0), "1.010");
  EXPECT_EQ(nees_text(report.filter, 1), "1.500*");
  EXPECT_EQ(nees_text(report.filter, 2), "-") << "no such group under way";
}

TEST(ReportNumbers, RatiosAreThoseOfTheBlock) {
  const ConsistencyReport report = small_report();
  EXPECT_EQ(ratio_text(report, report.smoother, report.layout.blocks()[0]), "1.250");
  EXPECT_EQ(ratio_text(report, report.smoother, report.layout.blocks()[1]), "0.500");
  EXPECT_EQ(ratio_text(report, report.smoother, Block::kGyroScale), "-") << "not estimated";
  EXPECT_EQ(ratio_text(report, EstimatorConsistency{}, report.layout.blocks()[0]), "-") << "not seen";
}

TEST(ReportNumbers, BandsSharesAndHeadings) {
  EXPECT_EQ(band_text({0.9341, 1.0679}), "0.934 to 1.068");
  EXPECT_EQ(percent(0.999), "99.9 %");
  EXPECT_EQ(heading_text({}), "-");
  EXPECT_EQ(heading_text({.runs = 3, .largest = 0.0349, .largest_ratio = 2.34}), "2.00 deg, 2.3 sigma");
}

TEST(EnsembleVerdict, SaysWhatIsOutside) {
  EXPECT_EQ(consistency_verdict(added({.runs = 30}).report()),
            "Consistent: over 30 runs, under way, the NEES of every group is 1 within its bounds (99.9 %).");
  // Every group of both is outside; six of them are named.
  const ConsistencyReport wrong = added({.runs = 30, .claimed = 0.5}).report();
  const std::string line = consistency_verdict(wrong);
  EXPECT_TRUE(contains(line, "Not consistent: over 30 runs, under way, the NEES of filter whole, ")) << line;
  EXPECT_TRUE(contains(line, std::to_string(2 * wrong.groups.size() - 6) + " more is not 1 (99.9 %).")) << line;
}

TEST(EnsembleVerdict, NamesAFewWithoutMore) {
  EXPECT_EQ(
      consistency_verdict(small_report()),
      "Not consistent: over 20 runs, under way, the NEES of filter position, smoother position is not 1 (99.9 %).");
}

TEST(EnsembleVerdict, SaysWhatWasNotSeenAndWhatFailed) {
  Consistency nothing{Ensemble{}.grid};
  nothing.add_failure({1, "lost"});
  nothing.add_failure({2, "lost"});
  EXPECT_EQ(
      consistency_verdict(nothing.report()),
      "Not consistent: the filter was not seen under way; the smoother was not seen under way; 2 of 2 runs failed.");
}

}  // namespace
}  // namespace piste::test
