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

}  // namespace
}  // namespace piste
