// The noise of the axes of a sensor, however it is mounted.

#include "piste/core/sensor.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "piste/math/so3.h"

namespace piste::test {
namespace {

TriadErrors triad(const Vector3d& densities) {
  TriadErrors errors;
  errors.set_densities(densities);
  return errors;
}

TEST(Sensor, DensitiesReadBack) {
  const Vector3d densities(1, 2, 3);
  const TriadErrors errors = triad(densities);
  EXPECT_LT((errors.densities() - densities).norm(), 1e-15);
  EXPECT_NEAR(errors.noise, std::sqrt((1 + 4 + 9) / 3.0), 1e-15);  // the rms: what one number stands for
  EXPECT_LT((errors.noise_variance() - Vector3d(1, 4, 9)).norm(), 1e-14);
}

TEST(Sensor, TurnsWithItsAxes) {
  ImuSensor sensor;
  sensor.gyro = triad({1, 2, 3});
  sensor.accel = triad({4, 5, 6});
  Matrix3d R_bs;  // +y -x +z: forward is the sensor's y, right its -x
  R_bs << 0, 1, 0, -1, 0, 0, 0, 0, 1;
  const ImuSensor body = turned(sensor, R_bs);
  EXPECT_LT((body.gyro.densities() - Vector3d(2, 1, 3)).norm(), 1e-15);
  EXPECT_LT((body.accel.densities() - Vector3d(5, 4, 6)).norm(), 1e-15);
}

// Along axes between two of the sensor's, a component is the sum of both.
TEST(Sensor, MixesVariances) {
  ImuSensor sensor;
  sensor.gyro = triad({1, 2, 3});
  const ImuSensor body = turned(sensor, so3_exp(Vector3d(0, 0, std::numbers::pi / 4)).toRotationMatrix());
  EXPECT_LT((body.gyro.noise_variance() - Vector3d(2.5, 2.5, 9)).norm(), 1e-14);
  EXPECT_NEAR(body.gyro.noise_variance().sum(), 14, 1e-14);
}

}  // namespace
}  // namespace piste::test
