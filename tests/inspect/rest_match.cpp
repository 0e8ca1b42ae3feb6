#include "inspect/rest_match.h"

#include <gtest/gtest.h>

namespace piste::test {
namespace {

constexpr double kAhead = 12.3;  // s

std::vector<Interval> later(std::vector<Interval> intervals) {
  for (Interval& i : intervals) i = {i.start + kAhead, i.end + kAhead};
  return intervals;
}

// A run between two rests; one log sees a rest too many, and the departure a second late.
TEST(RestMatch, TellsHowFarTheClocksAreApart) {
  const Rests receiver{{{0, 61}, {1900, 1960}}, {0, 1960}};
  const Rests imu{later({{0, 60}, {700, 703}, {1900, 1960}}), {kAhead, 1960 + kAhead}};
  const auto offset = match_rests(imu, receiver);
  ASSERT_TRUE(offset);
  EXPECT_NEAR(*offset, kAhead, 1);
  const auto turned = match_rests(receiver, imu);
  ASSERT_TRUE(turned);
  EXPECT_NEAR(*turned, -kAhead, 1);
}

// A tram that stops each minute for as long: it may be any of them.
TEST(RestMatch, TellsNothingOfRestsThatAreAlike) {
  std::vector<Interval> stops;
  for (int i = 0; i < 30; ++i) stops.push_back({60.0 * i, 60.0 * i + 20});
  EXPECT_FALSE(match_rests({later(stops), {kAhead, 1800 + kAhead}}, {stops, {0, 1800}}));
}

TEST(RestMatch, TellsNothingWithoutRestOrMotion) {
  EXPECT_FALSE(match_rests({{}, {0, 500}}, {{{0, 60}}, {0, 500}}));
  EXPECT_FALSE(match_rests({{{0, 500}}, {0, 500}}, {{{0, 500}}, {0, 500}}));
}

}  // namespace
}  // namespace piste::test
