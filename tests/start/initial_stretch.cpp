// Rests that are filtered by fewer samples, and rows between rows.

#include "piste/start/initial_stretch.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "piste/smoother/rts.h"
#include "support/synthetic_log.h"

namespace piste {
namespace {

// A rest and a motion of some seconds, with samples at rest marked as such.
test::SyntheticRun rest_and_motion() {
  test::SyntheticRun s = test::synthetic_run(12, {Block::kGyroBias, Block::kAccelBias});
  s.options.attitude.clear();
  s.log.attitude.clear();
  for (ImuSample& sample : s.log.imu) sample.at_rest = s.log.rest.front().contains(sample.time - 0.005);
  return s;
}

double farthest(const Estimate& a, const Estimate& b, const Sigmas& sigmas) {
  const FullError difference = boxminus(a, b);
  return std::max({difference.segment<3>(full_offset(Block::kPosition)).norm() / sigmas.position.norm(),
                   difference.segment<3>(full_offset(Block::kVelocity)).norm() / sigmas.velocity.norm(),
                   difference.segment<3>(full_offset(Block::kAttitude)).norm() / sigmas.euler.norm()});
}

TEST(InitialStretch, ARestIsAsInformativeByFewerSamples) {
  const test::SyntheticRun s = rest_and_motion();
  const FilterRun all = run_filter(s.log, s.options, s.start, Keep::kHistory);
  const FilterRun fewer = run_filter(s.log, s.options, s.start, Keep::kHistory, {}, {.rest_step = 0.1});
  const auto rest = static_cast<std::size_t>(std::ranges::count_if(s.log.imu, &ImuSample::at_rest));
  ASSERT_GT(rest, 150u);
  EXPECT_LT(fewer.epochs, all.epochs - rest * 8 / 10);
  EXPECT_GT(fewer.epochs, all.epochs - rest);
  const Solution expected = smooth_rts(all), found = smooth_rts(fewer);
  std::size_t i = 0;
  for (std::size_t j = 0; j < found.size(); ++j) {
    while (expected.time(i) < found.time(j) - 1e-6) ++i;
    ASSERT_NEAR(expected.time(i), found.time(j), 1e-6);
    const Sigmas sigmas = expected.sigmas(i);
    ASSERT_LT(farthest(found.estimate(j), expected.estimate(i), sigmas), 0.2) << found.time(j);
    ASSERT_NEAR(found.sigmas(j).euler.norm() / sigmas.euler.norm(), 1, 0.05) << found.time(j);
  }
}

// The rows of the stretch replace those of the filter, and the smoother still processes the filter's own.
TEST(InitialStretch, TheSmootherUsesTheFiltersOwnRows) {
  const test::SyntheticRun s = rest_and_motion();
  const double begin = s.log.imu.front().time;
  const FoundStart found{s.start, "given", begin + 6};
  const InitialStretch stretch = initial_stretch(s.log, s.options, found);
  ASSERT_GT(stretch.rows.size(), 0u);
  for (const double end : {begin + 4, begin + 10}) {  // within the stretch, and after it
    const FilterRun run = filter_from(stretch, s.log, s.options, found, Keep::kHistory, {}, end);
    const bool goes_on = end > *found.aligned;
    const FilterRun plain = goes_on ? run_filter(s.log, s.options, without_alignment(s.log.world, found),
                                                 Keep::kHistory, {}, {.end = end}, stretch.about)
                                    : run_filter(s.log, s.options, s.start, Keep::kHistory, {}, {.end = end});
    const std::size_t replaced = stretch.rows_of(run.solution);
    ASSERT_EQ(replaced == run.solution.size(), !goes_on);
    EXPECT_NE(run.solution.estimate(replaced / 2).p_wb, plain.solution.estimate(replaced / 2).p_wb);
    const Solution a = smooth_rts(run), b = smooth_rts(plain);
    ASSERT_EQ(a.size(), b.size());
    for (std::size_t i = 0; i < a.size(); ++i) ASSERT_EQ(a.estimate(i).p_wb, b.estimate(i).p_wb) << "row " << i;
  }
}

TEST(InitialStretch, ReplacesRowsByInterpolation) {
  const test::SyntheticRun s = rest_and_motion();
  const Solution all = smooth_rts(run_filter(s.log, s.options, s.start, Keep::kHistory));
  Solution known(all.layout(), all.world()), filtered = all;
  known.fixed = all.fixed;
  for (std::size_t i = 9; i < 110; i += 10) known.append(all.time(i), all.estimate(i), all.sigmas(i));
  replace_rows(filtered, known);
  for (std::size_t i = 0; i < all.size(); ++i) {
    if (i > 109 || i % 10 == 9) {
      ASSERT_EQ(filtered.estimate(i).p_wb, all.estimate(i).p_wb) << "row " << i;
      continue;
    }
    const std::size_t after = std::max<std::size_t>(9, i - i % 10 + 9);
    ASSERT_EQ(filtered.sigmas(i).position, all.sigmas(after).position) << "row " << i;
    if (i < 9) continue;
    const double part = static_cast<double>(i % 10 + 1) / 10;
    const Vector3d line = (1 - part) * all.estimate(after - 10).p_wb + part * all.estimate(after).p_wb;
    ASSERT_LT((filtered.estimate(i).p_wb - line).norm(), 1e-6) << "row " << i;
  }
}

}  // namespace
}  // namespace piste
