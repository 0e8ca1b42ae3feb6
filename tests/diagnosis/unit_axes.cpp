#include "diagnosis/unit_axes.h"

#include <gtest/gtest.h>

#include <cmath>

#include "piste/core/imu_array.h"
#include "piste/math/units.h"
#include "support/text_file.h"

namespace piste::test {
namespace {

constexpr double kWindow = 0.1;

// Two IMUs that are alike on a body that turns about all axes; what the second measures is turned by `turned`, times
// `factor`, and late.
struct Pair {
  Vector3d turned = Vector3d::Zero();
  double factor = 1, late = 0;
};

std::vector<ImuSensor> sensors() {
  ImuSensor sensor;
  sensor.gyro.noise = 0.05 * kDegree;
  return {sensor, sensor};
}

Vector3d rate(double t) { return Vector3d(0.3 * std::sin(3 * t), 0.2 * std::cos(2 * t), 0.4 * std::sin(1.3 * t + 1)); }

Log log_of(const Pair& pair) {
  Log log;
  log.counts.units = {{.name = "a"}, {.name = "b"}};
  log.parity.resize(1);
  const UnitVector noise = unit_noise(sensors(), &ImuSensor::gyro), w = unit_weights(noise);
  const UnitMatrix L = parity_rows(noise);
  const Matrix3d R = so3_exp(pair.turned).toRotationMatrix();
  for (int i = 0; i < 600; ++i) {
    const double t = kWindow * i;
    const Vector3d a = rate(t), b = pair.factor * R * rate(t - pair.late) + Vector3d(0.01, -0.02, 0.01);  // its bias
    ParityFix& fix = log.parity[0].emplace_back();
    fix.time = t;
    fix.duration = kWindow;
    fix.rate = w(0) * a + w(1) * b;
    fix.gyro.emplace();
    fix.gyro->value = L(0, 0) * a + L(1, 0) * b;
  }
  return log;
}

TEST(UnitAxes, SaysByHowMuchAnImuIsTurned) {
  EXPECT_TRUE(unit_axes_lines(log_of({}), sensors()).empty());
  EXPECT_TRUE(unit_axes_lines(log_of({.factor = 1.03}), sensors()).empty()) << "a scale is no rotation";
  for (const double degrees : {5., 90., 179.}) {
    const auto lines = unit_axes_lines(log_of({.turned = Vector3d(0, 0, degrees * kDegree)}), sensors());
    ASSERT_EQ(lines.size(), 1U) << degrees;
    EXPECT_TRUE(contains(lines[0], "IMU b turns about axes that are ")) << lines[0];
    EXPECT_TRUE(contains(lines[0], " deg off those of IMU a; check its `axes`, `boresight` and `clock`")) << lines[0];
  }
  const auto five = unit_axes_lines(log_of({.turned = Vector3d(0.05, 0, 0.07)}), sensors());
  ASSERT_EQ(five.size(), 1U);
  EXPECT_TRUE(contains(five[0], "4.9 deg off")) << five[0];
}

TEST(UnitAxes, SaysWhichImuDoesNotTurnWithTheFirst) {
  for (const Pair& pair : {Pair{.late = 0.4}, Pair{.factor = 1 / kDegree}}) {
    const auto lines = unit_axes_lines(log_of(pair), sensors());
    ASSERT_EQ(lines.size(), 1U);
    EXPECT_TRUE(contains(lines[0], "IMU b does not turn as IMU a does")) << lines[0];
  }
}

// What is turned about the only axis of the motion looks the same, and a log without windows says nothing.
TEST(UnitAxes, SaysNothingOfWhatTheMotionDoesNotTell) {
  Log log = log_of({});
  log.parity[0].resize(50);
  EXPECT_TRUE(unit_axes_lines(log, sensors()).empty());
  log.parity[0].clear();
  EXPECT_TRUE(unit_axes_lines(log, sensors()).empty());
  EXPECT_TRUE(unit_axes_lines({}, {}).empty());
}

}  // namespace
}  // namespace piste::test
