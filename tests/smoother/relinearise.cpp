// A run linearised about its own smoothed trajectory: the motion between two estimates, and where it stands still.

#include "smoother/relinearise.h"

#include <gtest/gtest.h>

#include "piste/smoother/rts.h"
#include "support/random.h"
#include "support/synthetic_log.h"

namespace piste {
namespace {

TEST(Reference, TheMotionBetweenTwoEstimatesIsWhatLedFromOneToTheOther) {
  const World world(Geodetic{0.8, 0.1, 1500});
  test::Random random(5);
  const double dt = 0.01;
  for (int k = 0; k < 20; ++k) {
    Estimate from = random.estimate();
    from.p_wb = random.vector(50);
    const Gravity gravity = world.gravity(from.p_wb);
    const Vector3d rate = random.vector(2), force = random.vector(10);
    ImuStep step{dt, dt * rate, dt * force, Vector3d::Zero(), Vector3d::Zero()};
    Estimate to = from;
    mechanize(to, step, world.earth_rate(), gravity);
    const BodyMotion found = motion_between(from, to, dt, world.earth_rate(), gravity);
    EXPECT_LT((found.rate - rate).norm(), 1e-6);
    // The force turns by ω dt within the step; its mean is less by (ω dt)² / 24, and gravity and the Earth add little.
    const double turned = rate.norm() * dt;
    EXPECT_LT((found.force - force).norm(), turned * turned / 24 * force.norm() + 1e-5);
  }
}

double furthest_apart(const Solution& a, const Solution& b) {
  double furthest = 0;
  for (std::size_t i = 0; i < a.size(); ++i) {
    const FullError difference = boxminus(a.estimate(i), b.estimate(i));
    const Sigmas sigma = b.sigmas(i);
    furthest = std::max({furthest, difference.head<3>().cwiseQuotient(sigma.position).cwiseAbs().maxCoeff(),
                         difference.segment<3>(full_offset(Block::kAttitude)).norm() / sigma.euler.norm()});
    for (const Block block : a.layout().blocks()) {
      if (is_navigation(block) || info(block).size != 3) continue;
      const int at = full_offset(block);
      furthest = std::max(furthest, difference.segment<3>(at).norm() / sigma.blocks.segment<3>(at).norm());
    }
  }
  return furthest;
}

TEST(Relinearise, StandsStillAfterFewSteps) {
  const std::vector<Block> estimate{Block::kGyroBias,  Block::kAccelBias,  Block::kGyroDrift, Block::kAccelDrift,
                                    Block::kGyroScale, Block::kAccelScale, Block::kLeverArm};
  test::SyntheticRun s = test::synthetic_run(30, estimate);
  s.options.attitude.clear();
  s.log.attitude.clear();
  const FilterRun first = run_filter(s.log, s.options, s.start, Keep::kHistory);
  const FilterRun second = relinearised(s.log, s.options, s.start, first);
  const FilterRun third = relinearised(s.log, s.options, s.start, second);
  const Solution once = smooth_rts(first), twice = smooth_rts(second), again = smooth_rts(third);
  ASSERT_EQ(once.size(), twice.size());
  EXPECT_GT(furthest_apart(twice, once), 0.01) << "there was nothing to do";
  EXPECT_LT(furthest_apart(again, twice), 0.1 * furthest_apart(twice, once) + 0.01);
}

// About a reference the start's mean is beside the reference: what the start tells is not lost.
TEST(Relinearise, WhatTheStartTellsIsKept) {
  test::SyntheticRun s = test::synthetic_run(10, {Block::kGyroBias, Block::kAccelBias});
  s.log.gnss[1].clear();
  s.log.gnss[0].clear();
  s.log.attitude[0].clear();
  s.log.magnetic.clear();
  s.log.rest.clear();
  for (ImuSample& sample : s.log.imu) sample.at_rest = false;
  const FilterRun first = run_filter(s.log, s.options, s.start, Keep::kHistory);
  // A reference that is elsewhere; nothing is measured, so the result is the start carried on.
  Start elsewhere = s.start;
  elsewhere.x.p_wb += Vector3d(3, -2, 1);
  const FilterRun other = run_filter(s.log, s.options, elsewhere, Keep::kHistory);
  const FilterRun about = relinearised(s.log, s.options, s.start, other);
  const Solution expected = smooth_rts(first), found = smooth_rts(about);
  const std::size_t last = expected.size() - 1;
  EXPECT_LT((found.estimate(last).p_wb - expected.estimate(last).p_wb).norm(), 1e-3);
  EXPECT_LT((found.estimate(last).v_wb - expected.estimate(last).v_wb).norm(), 1e-4);
}

}  // namespace
}  // namespace piste
