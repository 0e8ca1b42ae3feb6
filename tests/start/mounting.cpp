// How an IMU sits against a reference attitude, from a motion that is known exactly.

#include "start/mounting.h"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <numbers>

#include "piste/math/statistics.h"
#include "support/motion.h"
#include "support/random.h"
#include "support/thorough.h"

namespace piste {
namespace {

using test::Random;
using test::WildMotion;

const Vector3d kBias(0.01, -0.02, 0.015);

struct Riding {
  Log log;
  Quaterniond q_rb;
};

/// 20 s of the motion at 100 Hz with a gyro bias, and a reference at 10 Hz; noise of the gyro [rad/s/√Hz] and of a fix.
Riding ride(const Quaterniond& q_rb, double gyro_noise, double fix_noise, Random& random) {
  const WildMotion motion;
  constexpr double kStart = 3, kStep = 0.01;
  Riding out{{}, q_rb};
  out.log.world = motion.world;
  for (ImuSample s : motion.samples(kStart, kStart + 20, kStep)) {
    s.dtheta += kStep * kBias + random.vector(gyro_noise * std::sqrt(kStep));
    out.log.imu.push_back(s);
  }
  out.log.attitude.resize(1);
  for (int i = 0; i <= 200; ++i) {
    const double t = kStart + 0.1 * i;
    const Quaterniond q_wr = motion.at(t).q_wb * q_rb.conjugate();
    out.log.attitude[0].push_back({t, so3_exp(random.vector(fix_noise)) * q_wr, 1e-6 * Matrix3d::Identity()});
  }
  return out;
}

Vector3d error_of(const Mounting& found, const Riding& truth) { return so3_log(truth.q_rb * found.q_rb.conjugate()); }

TEST(Mounting, IsFoundAtAnyRotation) {
  Random random(1);
  std::vector<Quaterniond> all{Quaterniond::Identity(), so3_exp({0, 0, std::numbers::pi})};
  for (int i = 0; i < 8; ++i) all.push_back(random.rotation());
  for (const Quaterniond& q_rb : all) {
    const Riding truth = ride(q_rb, 0, 0, random);
    const auto found = find_mounting(truth.log);
    ASSERT_TRUE(found);
    // What is left is coning between the samples, and a bias that turns with the body over half a second.
    EXPECT_LT(error_of(*found, truth).norm(), 1e-3);
    EXPECT_LT((found->gyro_bias - kBias).norm(), 1e-3);
  }
}

TEST(Mounting, ErrorsAreWhatTheCovarianceSays) {
  Random random(2);
  const int runs = test::seeds(30, 300);
  double nees = 0;
  for (int i = 0; i < runs; ++i) {
    const Riding truth = ride(random.rotation(), 2e-3, 2e-3, random);
    const auto found = find_mounting(truth.log);
    ASSERT_TRUE(found);
    const Vector3d e = error_of(*found, truth);
    nees += e.dot(found->covariance.llt().solve(e)) / (3 * runs);
    EXPECT_LT(found->covariance.diagonal().maxCoeff(), 1e-5);
  }
  const Band band = chi_squared_band(0.999, 3, runs);
  EXPECT_TRUE(band.contains(nees)) << nees << " outside " << band.low << " to " << band.high;
}

TEST(Mounting, LeavesOutWhatTheGyroDidNotMeasure) {
  Random random(3);
  const Riding whole = ride(random.rotation(), 0, 0, random);
  for (const bool gap : {true, false}) {
    Riding spoilt = whole;
    for (std::size_t i = 500; i < 700; ++i) {
      ImuSample& s = spoilt.log.imu[i];
      s.dtheta = Vector3d(0.1, 0.1, 0.1);
      if (gap) {
        s.gap = GapNoise{};
      } else {
        s.clipped_gyro = 1;
      }
    }
    const auto found = find_mounting(spoilt.log);
    ASSERT_TRUE(found);
    EXPECT_LT(error_of(*found, whole).norm(), 2e-3);
    for (std::size_t i = 500; i < 700; ++i) {  // not said to be so, it counts
      spoilt.log.imu[i].gap.reset();
      spoilt.log.imu[i].clipped_gyro = 0;
    }
    const auto believed = find_mounting(spoilt.log);
    EXPECT_TRUE(!believed || error_of(*believed, whole).norm() > 0.05);
  }
}

TEST(Mounting, IsNotMadeUp) {
  Random random(4);
  Riding some = ride(random.rotation(), 1e-3, 1e-3, random);
  Log without = some.log;
  without.attitude.clear();
  EXPECT_FALSE(find_mounting(without)) << "no reference";
  Log few = some.log;
  few.attitude[0].resize(45);  // nine steps of half a second
  EXPECT_FALSE(find_mounting(few));
  Log rare = some.log;
  std::erase_if(rare.attitude[0], [n = 0](const AttitudeFix&) mutable { return n++ % 25 != 0; });
  EXPECT_FALSE(find_mounting(rare)) << "fixes 2.5 s apart";
  Log still = some.log;
  for (ImuSample& s : still.imu) s.dtheta = random.vector(1e-4);
  for (AttitudeFix& fix : still.attitude[0]) fix.q_wr = so3_exp(random.vector(1e-3));
  EXPECT_FALSE(find_mounting(still)) << "nothing turns";
  EXPECT_TRUE(find_mounting(some.log));

  // A first source without fixes is passed over.
  some.log.attitude.insert(some.log.attitude.begin(), std::vector<AttitudeFix>{});
  EXPECT_TRUE(find_mounting(some.log));
}

}  // namespace
}  // namespace piste
