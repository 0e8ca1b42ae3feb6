#include "inspect/column_repair.h"

#include <gtest/gtest.h>

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
