#include "start/start_place.h"

#include <gtest/gtest.h>

#include "support/motion.h"
#include "support/random.h"

namespace piste::test {
namespace {

TEST(StartPlace, AnAttitudeIsCarriedBackThroughTheGyroAndTheEarth) {
  const WildMotion motion;
  const double begin = 3, end = 23;  // the Earth turns by 1.5 mrad in between
  Log log;
  log.world = motion.world;
  log.imu = motion.samples(begin, end, 0.002);
  const Vector3d bias(0.01, -0.02, 0.015);
  for (ImuSample& s : log.imu) s.dtheta += s.interval * bias;
  const Quaterniond found = carry_back(log, motion.at(end).q_wb, begin, end, bias);
  EXPECT_LT(found.angularDistance(motion.at(begin).q_wb), 3e-4);
}

TEST(StartPlace, LevellingTurnsAboutAHorizontalAxisByTheTiltAlone) {
  Random random(1);
  for (int i = 0; i < 20; ++i) {
    const Quaterniond q = random.rotation();
    const Vector3d down_b = random.vector(9.8);
    const Quaterniond found = levelled(q, down_b);
    const Vector3d down_w = q * down_b.normalized();
    EXPECT_LT((found * down_b.normalized() - Vector3d::UnitZ()).norm(), 1e-12);
    const Vector3d turn = so3_log(found * q.conjugate());
    EXPECT_NEAR(turn.z(), 0, 1e-9);
    EXPECT_NEAR(turn.norm(), std::acos(std::clamp(down_w.z(), -1.0, 1.0)), 1e-7);
  }
}

TEST(StartPlace, AFirstFixThatContradictsTheNextTwoIsPassedOver) {
  Random random(2);
  GnssOptions options;
  options.lever_arm = Vector3d(0.1, -0.2, -0.4);
  std::vector<GnssFix> fixes;
  for (int i = 0; i < 5; ++i) fixes.push_back({10.0 + i, Vector3d(3, 4, 5), Vector3d(0.02, 0.02, 0.03), {}});
  Start start;
  start.time = 9.5;
  start.x.q_wb = random.rotation();
  start.covariance = Covariance::Identity(9, 9);
  place_at_rest(World(), start, {fixes, options}, {});
  const Vector3d expected = start.x.p_wb;
  EXPECT_LT((expected + start.x.q_wb * options.lever_arm - Vector3d(3, 4, 5)).norm(), 1e-12);
  fixes.front().position += Vector3d(500, 0, 0);
  place_at_rest(World(), start, {fixes, options}, {});
  EXPECT_LT((start.x.p_wb - expected).norm(), 1e-12);
}

}  // namespace
}  // namespace piste::test
