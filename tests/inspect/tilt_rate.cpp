// The unit of gyroscopes by the direction of gravity.

#include "inspect/tilt_rate.h"

#include <gtest/gtest.h>

#include <cmath>

#include "piste/math/so3.h"
#include "piste/math/units.h"
#include "support/random.h"

namespace piste::test {
namespace {

// A body that rocks about two axes, at 30 Hz. `along`: whether the force stays along its own axis, as a multirotor's.
ImuRecording rocking(double unit, bool along) {
  constexpr double kStep = 1.0 / 30;
  ImuRecording imu;
  Random random(11);
  Quaterniond q = Quaterniond::Identity();
  for (int i = 0; i < 1500; ++i) {
    const double t = kStep * i;
    const Vector3d rate(1.2 * std::sin(1.7 * t), 0.9 * std::cos(1.1 * t), 0.4);
    q = q * so3_exp(kStep * rate);
    imu.time.push_back(t + kStep);
    imu.gyro.emplace_back(rate / unit);
    imu.accel.emplace_back((along ? Vector3d(0, 0, -9.8) : Vector3d(q.conjugate() * Vector3d(0, 0, -9.8))) +
                           0.5 * (random.uniform() - 0.5) * Vector3d::Ones());
  }
  return imu;
}

TEST(TiltRate, GravityTellsTheUnit) {
  EXPECT_EQ(rate_factor_by_tilt(rocking(1, false)), 1.0);
  EXPECT_EQ(rate_factor_by_tilt(rocking(kDegree, false)), kDegree);
  EXPECT_EQ(rate_factor_by_tilt(rocking(kDegreesPerRadian, false)), kDegreesPerRadian);
}

TEST(TiltRate, AForceAlongItsOwnAxisTellsNothing) {
  EXPECT_FALSE(rate_factor_by_tilt(rocking(1, true)));
  EXPECT_FALSE(rate_factor_by_tilt(rocking(kDegree, true)));
}

}  // namespace
}  // namespace piste::test
