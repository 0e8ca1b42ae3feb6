#include "diagnosis/imu_motion.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>

#include "piste/core/imu_array.h"
#include "piste/math/units.h"
#include "support/text_file.h"

namespace piste::test {
namespace {

constexpr double kWindow = 0.1;

// Two IMUs that are alike on a body that turns about all axes; the rates of the second are turned by `turned`, times
// `factor`, and late, and its forces are those at `place` beside the first.
struct Pair {
  Vector3d turned = Vector3d::Zero();
  double factor = 1, late = 0;
  Vector3d place = Vector3d::Zero();
};

std::vector<ImuSensor> sensors() {
  ImuSensor sensor;
  sensor.gyro.noise = 0.05 * kDegree;
  sensor.accel.noise = 1e-3;
  return {sensor, sensor};
}

Vector3d rate(double t) { return Vector3d(0.3 * std::sin(3 * t), 0.2 * std::cos(2 * t), 0.4 * std::sin(1.3 * t + 1)); }

Vector3d force(double t) {
  return Vector3d(0.8 * std::sin(1.7 * t), 0.5 * std::cos(0.9 * t), -9.8 + std::sin(2.3 * t));
}

Log log_of(const Pair& pair) {
  Log log;
  log.counts.imus = {{.name = "a"}, {.name = "b"}};
  log.parity.resize(1);
  const ImuVector noise = imu_noise(sensors(), &ImuSensor::gyro), w = imu_weights(noise);
  const ImuMatrix L = parity_rows(noise);
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
    constexpr double kLittle = 1e-4;
    const Vector3d turning = (rate(t + kLittle) - rate(t - kLittle)) / (2 * kLittle);
    const Vector3d f = force(t), g = f + turning.cross(pair.place) + a.cross(a.cross(pair.place));
    fix.force = w(0) * f + w(1) * g;
    fix.accel.emplace();
    fix.accel->value = L(0, 0) * f + L(1, 0) * g;
  }
  return log;
}

TEST(ImuMotion, SaysByHowMuchAnImuIsTurned) {
  EXPECT_TRUE(imu_motion_lines(log_of({}), sensors()).empty());
  EXPECT_TRUE(imu_motion_lines(log_of({.factor = 1.03}), sensors()).empty()) << "a scale is no rotation";
  for (const double degrees : {5., 90., 179.}) {
    const auto lines = imu_motion_lines(log_of({.turned = Vector3d(0, 0, degrees * kDegree)}), sensors());
    ASSERT_EQ(lines.size(), 1U) << degrees;
    EXPECT_TRUE(contains(lines[0], "IMU b turns about axes that are ")) << lines[0];
    EXPECT_TRUE(contains(lines[0], " deg off those of IMU a; check its `axes`, `boresight` and `clock`")) << lines[0];
  }
  const auto five = imu_motion_lines(log_of({.turned = Vector3d(0.05, 0, 0.07)}), sensors());
  ASSERT_EQ(five.size(), 1U);
  EXPECT_TRUE(contains(five[0], "4.9 deg off")) << five[0];
}

TEST(ImuMotion, SaysWhichImuDoesNotTurnWithTheFirst) {
  const auto lines = imu_motion_lines(log_of({.factor = 1 / kDegree}), sensors());
  ASSERT_EQ(lines.size(), 1U);
  EXPECT_TRUE(contains(lines[0], "IMU b does not turn as IMU a does")) << lines[0];
}

TEST(ImuMotion, SaysByHowMuchAClockIsOff) {
  for (const double late : {0.4, 0.15, -0.25, -0.06}) {
    const auto lines = imu_motion_lines(log_of({.late = late}), sensors());
    ASSERT_EQ(lines.size(), 1U) << late;
    const std::string said =
        fmt::format("IMU b turns some {:.2g} s {} than IMU a", std::abs(late), late > 0 ? "later" : "earlier");
    EXPECT_TRUE(contains(lines[0], said)) << lines[0];
  }
  EXPECT_TRUE(imu_motion_lines(log_of({.late = 0.01}), sensors()).empty());
  const auto both = imu_motion_lines(log_of({.turned = Vector3d(0, 0, 90 * kDegree), .late = 0.2}), sensors());
  ASSERT_EQ(both.size(), 1U);
  EXPECT_TRUE(contains(both[0], "turns some 0.2 s later")) << both[0];
}

TEST(ImuMotion, SaysHowFarAnImuSitsFromWhereItsLeverArmPutsIt) {
  EXPECT_TRUE(imu_motion_lines(log_of({.place = Vector3d(0.1, 0, 0)}), sensors()).empty());
  for (const Vector3d& place : {Vector3d(1, 0, 0), Vector3d(0, -0.3, 0.4)}) {
    const auto lines = imu_motion_lines(log_of({.place = place}), sensors());
    ASSERT_EQ(lines.size(), 1U);
    const std::string said = fmt::format("IMU b sits some {:.1g} m from where its `lever_arm` puts it", place.norm());
    EXPECT_TRUE(contains(lines[0], said)) << lines[0];
  }
}

// What is turned about the only axis of the motion looks the same, and a log without windows says nothing.
TEST(ImuMotion, SaysNothingOfWhatTheMotionDoesNotTell) {
  Log log = log_of({});
  log.parity[0].resize(50);
  EXPECT_TRUE(imu_motion_lines(log, sensors()).empty());
  log.parity[0].clear();
  EXPECT_TRUE(imu_motion_lines(log, sensors()).empty());
  EXPECT_TRUE(imu_motion_lines({}, {}).empty());
}

}  // namespace
}  // namespace piste::test
