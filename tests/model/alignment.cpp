#include "piste/model/alignment.h"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <limits>

#include "piste/math/statistics.h"
#include "support/motion.h"
#include "support/random.h"

namespace piste {
namespace {

using test::Random;
using test::WildMotion;

TEST(Level, GravityGivesRollAndPitch) {
  Random random(1);
  for (int i = 0; i < 20; ++i) {
    const Vector3d euler(0.9 * random.gaussian(), 0.5 * random.gaussian(), random.gaussian());
    const Quaterniond q = from_euler(euler);
    EXPECT_LT(level(q.conjugate() * Vector3d(0, 0, -9.8), to_euler(q).z()).angularDistance(q), 1e-12);
  }
}

GnssOptions receiver() {
  GnssOptions r;
  r.lever_arm = Vector3d(-0.1, 0.05, -0.4);
  return r;
}

struct Window {
  std::vector<ImuSample> imu;
  std::vector<GnssFix> fixes;
};

Window window_of(const WildMotion& motion, double start, double length, double noise, Random& random) {
  Window w{motion.samples(start - 0.1, start + length + 0.2, 0.01), {}};
  for (int i = 0; i * 0.25 <= length; ++i) {
    GnssFix fix = motion.fix(start + 0.25 * i + 0.003, receiver().lever_arm);
    fix.position += noise * random.vector(0.02);
    fix.velocity->value += noise * random.vector(0.03);
    w.fixes.push_back(fix);
  }
  return w;
}

class Quadrant : public testing::TestWithParam<double> {};
INSTANTIATE_TEST_SUITE_P(Alignment, Quadrant, testing::Values(-3.0, -2.3, -1.2, -0.3, 0.4, 1.5, 2.4, 3.1));

TEST_P(Quadrant, IsFoundFromTheMotion) {
  Random random(2);
  WildMotion motion;
  motion.heading = GetParam();
  for (const bool position : {true, false}) {
    for (const bool velocity : {true, false}) {
      if (!position && !velocity) continue;
      GnssOptions r = receiver();
      r.use_position = position;
      r.use_velocity = velocity;
      const Window w = window_of(motion, 2, 5, 0, random);
      const auto found = align_in_motion(w.imu, w.fixes, r, {}, motion.gravity().value);
      ASSERT_TRUE(found);
      const auto truth = motion.at(found->time);
      EXPECT_EQ(found->time, w.fixes.front().time);
      // The rate of the Earth and coning are left out of it.
      EXPECT_LT(found->q_wb.angularDistance(truth.q_wb), 0.002);
      EXPECT_LT((found->v_wb - truth.v_wb).norm(), 0.1);
      if (position) {
        EXPECT_LT((found->p_wb - truth.p_wb).norm(), 0.2);
      }
    }
  }
}

TEST_P(Quadrant, KnowsHowSureItIs) {
  WildMotion motion;
  motion.heading = GetParam();
  Random random(3);
  double nees = 0;
  constexpr int kRuns = 30;
  for (int i = 0; i < kRuns; ++i) {
    const Window w = window_of(motion, 2 + 0.1 * i, 5, 3, random);  // noise above what the sigmas say
    const auto found = align_in_motion(w.imu, w.fixes, receiver(), {}, motion.gravity().value);
    ASSERT_TRUE(found);
    const Vector3d error = so3_log(motion.at(found->time).q_wb * found->q_wb.conjugate());
    nees += error.dot(found->covariance.inverse() * error) / (3 * kRuns);
  }
  const Band band = chi_squared_band(0.999, 3, kRuns);
  EXPECT_TRUE(band.contains(nees)) << nees << " outside " << band.low << " to " << band.high;
}

TEST(Alignment, ABodyAtRestTellsNoHeading) {
  WildMotion motion;
  motion.begin = 100;
  Random random(4);
  const Window w = window_of(motion, 2, 5, 1, random);
  const auto found = align_in_motion(w.imu, w.fixes, receiver(), {}, motion.gravity().value);
  // Either undetermined, or so unsure of the heading that nobody believes it.
  if (found) {
    EXPECT_GT(std::sqrt(found->covariance(2, 2)), 0.2);
  }
  EXPECT_FALSE(align_in_motion(w.imu, std::span(w.fixes).first(3), receiver(), {}, motion.gravity().value));
}

TEST(Alignment, AVelocityWithoutDownIsLeftOut) {
  const WildMotion motion;
  Random random(7);
  Window w = window_of(motion, 2, 5, 0, random);
  GnssOptions position_only = receiver();
  position_only.use_velocity = false;
  const auto expected = align_in_motion(w.imu, w.fixes, position_only, {}, motion.gravity().value);
  for (GnssFix& fix : w.fixes) fix.velocity->sigma.z() = std::numeric_limits<double>::infinity();
  const auto found = align_in_motion(w.imu, w.fixes, receiver(), {}, motion.gravity().value);
  ASSERT_TRUE(expected && found);
  EXPECT_EQ(found->q_wb.coeffs(), expected->q_wb.coeffs());
  EXPECT_EQ(found->v_wb, expected->v_wb);
}

TEST(Alignment, AGapInTheImuIsNotAligned) {
  const WildMotion motion;
  Random random(5);
  Window w = window_of(motion, 2, 5, 0, random);
  w.imu[100].gap = GapNoise{};
  EXPECT_FALSE(align_in_motion(w.imu, w.fixes, receiver(), {}, motion.gravity().value));
  w = window_of(motion, 2, 5, 0, random);
  w.imu.erase(w.imu.begin() + 100);
  EXPECT_FALSE(align_in_motion(w.imu, w.fixes, receiver(), {}, motion.gravity().value));
}

TEST(Alignment, AKnownGyroBiasIsTakenOut) {
  const WildMotion motion;
  Random random(6);
  Window w = window_of(motion, 2, 5, 0, random);
  const Vector3d bias(0.02, -0.03, 0.05);
  for (ImuSample& s : w.imu) s.dtheta += s.interval * bias;
  const auto known = align_in_motion(w.imu, w.fixes, receiver(), {bias, 0.001}, motion.gravity().value);
  const auto unknown = align_in_motion(w.imu, w.fixes, receiver(), {Vector3d::Zero(), 0.05}, motion.gravity().value);
  ASSERT_TRUE(known && unknown);
  EXPECT_LT(known->q_wb.angularDistance(motion.at(known->time).q_wb), 0.005);
  EXPECT_GT(unknown->q_wb.angularDistance(motion.at(known->time).q_wb), 0.02);
  EXPECT_GT(unknown->covariance(2, 2), 0.01);
}

}  // namespace
}  // namespace piste
