// What a caller of the smoother may rely on, whatever it computes: tests/law/smoother.cpp has that.

#include "piste/smoother/rts.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <stdexcept>
#include <vector>

#include "smoother/lagged_errors.h"
#include "support/synthetic_log.h"

namespace piste {
namespace {

// The last row is found first; whoever takes them in pieces has them in their order, every bit as in the whole.
TEST(Rts, RowsInPiecesAreThoseOfTheWhole) {
  const test::SyntheticRun s = test::synthetic_run(25, {Block::kGyroBias, Block::kAccelDrift});
  const auto scratch = std::filesystem::temp_directory_path() / "piste_test_rts";
  std::filesystem::create_directories(scratch);
  for (const bool in_file : {false, true}) {
    const FilterRun run = run_filter(s.log, s.options, s.start, Keep::kHistory, {}, {}, {}, {},
                                     in_file ? scratch : std::filesystem::path());
    const Solution whole = smooth_rts(run);
    ASSERT_GT(whole.size(), 2 * kRowsAtOnce);
    std::size_t taken = 0;
    const Solution rest = smooth_rts(run, {}, nullptr, nullptr, [&](Solution& rows, std::size_t first) {
      EXPECT_EQ(first, taken);
      EXPECT_LE(rows.size(), kRowsAtOnce);
      for (std::size_t i = 0; i < rows.size(); ++i, ++taken) {
        ASSERT_TRUE(std::ranges::equal(rows.row(i), whole.row(taken))) << taken;
      }
      EXPECT_TRUE(rows.fixed.lever_arm == whole.fixed.lever_arm);
    });
    EXPECT_EQ(taken, whole.size());
    EXPECT_TRUE(rest.empty());
    EXPECT_EQ(rest.sources, whole.sources);
  }
  std::filesystem::remove_all(scratch);
}

TEST(Rts, SaysHowFarItIs) {
  const test::SyntheticRun s = test::synthetic_run(25, {});
  const FilterRun run = run_filter(s.log, s.options, s.start, Keep::kHistory);
  std::vector<double> done;
  smooth_rts(run, [&](double part) { done.push_back(part); });
  ASSERT_FALSE(done.empty());
  EXPECT_TRUE(std::ranges::is_sorted(done));
  EXPECT_EQ(done.back(), 1);
}

TEST(Rts, NeedsAHistory) {
  const test::SyntheticRun s = test::synthetic_run(1, {});
  const FilterRun run = run_filter(s.log, s.options, s.start);
  EXPECT_THROW(smooth_rts(run), std::logic_error);
  EXPECT_THROW(smoothed_trajectory(run), std::logic_error);
  EXPECT_THROW(smooth_rows(run, {0}, {}), std::logic_error);
  EXPECT_THROW(variances(run, {}), std::logic_error);
}

TEST(Rts, OfNoNumbersThereIsNoVariance) {
  const test::SyntheticRun s = test::synthetic_run(1, {});
  const FilterRun run = run_filter(s.log, s.options, s.start, Keep::kHistory);
  EXPECT_TRUE(variances(run, {}).empty());
  EXPECT_EQ(lagged_covariances(run, {}, {}).size(), 0);
  smooth_rows(run, {}, [](std::size_t, const FilterState&, const SmoothedState&) { FAIL() << "none was asked for"; });
}

}  // namespace
}  // namespace piste
