#include "inspect/column_repair.h"

#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "piste/math/earth.h"
#include "piste/math/units.h"

namespace piste {
namespace {

// The number before a unit is a scale, which another unit does not change.
TEST(ColumnRepair, KeepsTheNumberBeforeAUnit) {
  ColumnMap map;
  map.uses["gyro"] = {{"x", "y", "z"}, "0.0609756 rad/s"};
  map.uses["accel"] = {{"a", "b", "c"}, "m/s^2"};
  LogMatch match;
  match.interval = 0.01;
  match.clock = ClockMatch{};
  match.turn_ratio = kDegreesPerRadian;
  match.force = 1;  // g
  const auto right = repaired(map, match);
  ASSERT_TRUE(right);
  EXPECT_EQ(right->find("gyro")->unit, "0.0609756 deg/s");
  EXPECT_EQ(right->find("accel")->unit, "g");
}

// A mapping of an IMU whose motion is known, and which has not been found wrong.
struct Imu {
  ColumnMap map;
  LogMatch match;

  explicit Imu(bool increments = false) {
    map.uses[increments ? "dtheta" : "gyro"] = {{"x", "y", "z"}, increments ? "rad" : "rad/s"};
    map.uses[increments ? "dvel" : "accel"] = {{"x", "y", "z"}, increments ? "m/s" : "m/s^2"};
    match.interval = 0.01;
    match.increments = increments;
    match.clock = ClockMatch{};
    match.motion = MotionMatch{};
  }
  std::string unit(const std::string& key) const {
    const auto right = repaired(map, match);
    return right && right->find(key) != nullptr ? right->find(key)->unit : "as it was";
  }
};

TEST(ColumnRepair, LeavesWhatAgreesOrIsNotKnown) {
  Imu imu;
  EXPECT_FALSE(repaired(imu.map, imu.match));
  imu.match.motion->gyro_factor = kDegree;
  EXPECT_TRUE(repaired(imu.map, imu.match));
  imu.match.interval = 0;
  EXPECT_FALSE(repaired(imu.map, imu.match)) << "times are not in seconds";
  imu.match.interval = 0.01;
  imu.match.clock.reset();
  EXPECT_FALSE(repaired(imu.map, imu.match)) << "the motion does not determine the clock";
}

TEST(ColumnRepair, RatesAndIncrements) {
  Imu rates;
  rates.match.motion->gyro_factor = rates.match.motion->accel_factor = 100;
  EXPECT_EQ(rates.unit("dtheta"), "rad");
  EXPECT_EQ(rates.unit("dvel"), "m/s");
  rates.match.motion->accel_factor = 1;
  EXPECT_EQ(rates.unit("dtheta"), "as it was") << "one triad alone is none";
  Imu increments(true);
  increments.match.motion->gyro_factor = increments.match.motion->accel_factor = 0.01;
  EXPECT_EQ(increments.unit("gyro"), "rad/s");
  EXPECT_EQ(increments.unit("accel"), "m/s^2");
  increments.match.motion->accel_factor = 1;
  EXPECT_EQ(increments.unit("gyro"), "as it was");
}

// A row a second: increments are as large as rates.
TEST(ColumnRepair, RatesOfASlowLogStayRates) {
  for (const double interval : {1.0, 0.8, 1.25}) {
    Imu rates, increments(true);
    rates.match.interval = increments.match.interval = interval;
    EXPECT_FALSE(repaired(rates.map, rates.match)) << interval;
    EXPECT_FALSE(repaired(increments.map, increments.match)) << interval;
    rates.match.motion.reset();
    rates.match.turn_ratio = 1.02;
    rates.match.force = 0.98 * kStandardGravity;
    EXPECT_FALSE(repaired(rates.map, rates.match)) << "by the turns alone, " << interval;
  }
}

TEST(ColumnRepair, UnitsOfBothTriads) {
  Imu imu;
  imu.match.motion->gyro_factor = kDegree;
  EXPECT_EQ(imu.unit("gyro"), "deg/s");
  imu.match.motion->gyro_factor = kDegreesPerRadian;
  imu.map.uses["gyro"].unit = "deg/s";
  EXPECT_EQ(imu.unit("gyro"), "rad/s");
  imu.match.motion->gyro_factor = 1;
  imu.match.motion->accel_factor = kStandardGravity;
  EXPECT_EQ(imu.unit("accel"), "g");
  imu.match.motion->accel_factor = 1 / kStandardGravity;
  imu.map.uses["accel"].unit = "0.5 g";
  EXPECT_EQ(imu.unit("accel"), "0.5 m/s^2");
  Imu increments(true);
  increments.match.motion->gyro_factor = kDegree;
  EXPECT_EQ(increments.unit("dtheta"), "deg");
}

// Of raw counts the range is one of a few, each twice the other.
TEST(ColumnRepair, TheRangeOfRawCounts) {
  Imu imu;
  imu.match.motion.reset();
  imu.match.turn_ratio = 2;
  imu.map.uses["gyro"].unit = "0.0609756 deg/s";
  EXPECT_EQ(imu.unit("gyro"), "0.0304878 deg/s") << "turns are twice as large as those of the track";
  imu.match.turn_ratio = 1.05;
  EXPECT_EQ(imu.unit("gyro"), "as it was");
  imu.match.turn_ratio = 0.5;
  EXPECT_EQ(imu.unit("gyro"), "as it was") << "no range is near";
  imu.match.turn_ratio = 2;
  imu.map.uses["gyro"].unit = "0.05 deg/s";
  EXPECT_EQ(imu.unit("gyro"), "as it was") << "no unit of counts";
}

TEST(ColumnRepair, TurnsAxes) {
  Imu imu;
  imu.match.motion->gyro_axes << 0, 1, 0, -1, 0, 0, 0, 0, 1;
  imu.map.uses["gyro"].axes = {"+y", "-x", "+z"};
  const auto right = repaired(imu.map, imu.match);
  ASSERT_TRUE(right);
  EXPECT_EQ(right->find("gyro")->axes, (std::vector<std::string>{"+x", "+y", "+z"}));
  imu.match.motion->gravity = false;
  EXPECT_FALSE(repaired(imu.map, imu.match)) << "without gravity nothing is known of axes";
}

struct Receiver {
  ColumnMap map;
  VelocityFit fit;

  Receiver() {
    map.uses["latitude"] = {{"lat"}, "deg"};
    map.uses["longitude"] = {{"lon"}, "deg"};
    map.uses["velocity"] = {{"n", "e", "d"}, "m/s"};
    map.uses["sigma_velocity"] = {{"s"}, "m/s"};
  }
};

TEST(ColumnRepair, OfAReceiver) {
  Receiver receiver;
  EXPECT_FALSE(repaired(receiver.map, receiver.fit));
  receiver.fit.scale = 3.6;
  auto right = repaired(receiver.map, receiver.fit);
  ASSERT_TRUE(right);
  EXPECT_EQ(right->find("velocity")->unit, "km/h");
  EXPECT_EQ(right->find("sigma_velocity")->unit, "km/h");
  receiver.fit = {};
  receiver.fit.interchanged = true;
  right = repaired(receiver.map, receiver.fit);
  ASSERT_TRUE(right);
  EXPECT_EQ(right->find("latitude")->names.front(), "lon");
  receiver.fit = {};
  receiver.fit.axes = Vector3d(1, 1, -1).asDiagonal();
  right = repaired(receiver.map, receiver.fit);
  ASSERT_TRUE(right);
  EXPECT_EQ(right->find("velocity")->axes, (std::vector<std::string>{"north", "east", "up"}));
  EXPECT_TRUE(right->find("sigma_velocity")->axes.empty()) << "one sigma of all axes";
}

TEST(ColumnRepair, NoMappingExpressesAColumnThatIsMissing) {
  Receiver receiver;
  receiver.map.uses["velocity"].names = {"n", "e"};
  receiver.fit.axes << 1, 0, 0, 0, 0, 1, 0, -1, 0;  // east would be down
  EXPECT_FALSE(repaired(receiver.map, receiver.fit));
}

TEST(ColumnRepair, WhatColumnsMend) {
  for (const LogFault fault :
       {LogFault::kIncrementsForRates, LogFault::kRatesForIncrements, LogFault::kGyroDegrees, LogFault::kGyroRadians,
        LogFault::kAccelG, LogFault::kAccelMetres, LogFault::kAccelSign, LogFault::kAxesMirrored, LogFault::kGyroAxes,
        LogFault::kLatitudeLongitude, LogFault::kVelocityEastNorth, LogFault::kVelocityUp, LogFault::kVelocityUnit}) {
    EXPECT_TRUE(is_mended_by_columns(fault)) << static_cast<int>(fault);
  }
  EXPECT_FALSE(is_mended_by_columns(LogFault::kClipped));
}

// A track with latitude and longitude exchanged and forces of the other sign look the same. A phone that does not say
// which sign it writes is the likelier of both.
TEST(ColumnRepair, ReversesForcesWhoseSignNobodyTells) {
  ColumnMap map;
  map.uses["gyro"] = {{"x", "y", "z"}, "rad/s"};
  map.uses["accel"] = {{"x", "y", "z"}, "m/s^2"};
  LogMatch match;
  match.interval = 0.01;
  match.clock = ClockMatch{};
  match.force = kStandardGravity;
  match.motion = MotionMatch{};
  match.motion->gyro_factor = 1;
  match.motion->gravity = match.motion->mirrored = true;
  EXPECT_FALSE(repaired(map, match)) << "the track is at fault";
  match.motion->sign_told = false;
  const auto right = repaired(map, match);
  ASSERT_TRUE(right);
  EXPECT_EQ(right->find("accel")->axes, (std::vector<std::string>{"-x", "-y", "-z"}));
  EXPECT_TRUE(right->find("gyro")->axes.empty());
}

}  // namespace
}  // namespace piste
