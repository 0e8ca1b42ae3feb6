#include "inspect/rest_match.h"

#include <gtest/gtest.h>

#include <random>

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

// Rests of a walk in town, of any length, as one log sees them; another sees each of them a little earlier or later.
std::vector<Interval> stops_of(unsigned seed, std::size_t count) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> rest(5, 9), walk(6, 10);
  std::vector<Interval> stops;
  for (double t = 0; stops.size() < count; t = stops.back().end + walk(random)) stops.push_back({t, t + rest(random)});
  return stops;
}
std::vector<Interval> seen_otherwise(std::vector<Interval> stops) {
  std::mt19937 random(1);
  std::uniform_real_distribution<double> error(-0.5, 0.5);
  for (Interval& i : stops) i = {i.start + error(random), i.end + error(random)};
  return stops;
}
Rests rests_of(std::vector<Interval> stops) {
  const Interval span{stops.front().start - 5, stops.back().end + 5};
  return {std::move(stops), span};
}

// Of a hundred rests all offsets are compared, of more the likely ones alone.
TEST(RestMatch, TellsAsMuchOfManyRestsAsOfFew) {
  for (const std::size_t count : {40U, 99U, 101U, 300U, 960U}) {
    const std::vector<Interval> stops = stops_of(3, count);
    const auto offset = match_rests(rests_of(later(seen_otherwise(stops))), rests_of(stops));
    ASSERT_TRUE(offset) << count;
    EXPECT_NEAR(*offset, kAhead, 0.7) << count;
    EXPECT_FALSE(match_rests(rests_of(stops_of(4, count)), rests_of(stops))) << count << ", of another walk";
  }
}

TEST(RestMatch, TellsNothingWithoutRestOrMotion) {
  EXPECT_FALSE(match_rests({{}, {0, 500}}, {{{0, 60}}, {0, 500}}));
  EXPECT_FALSE(match_rests({{{0, 500}}, {0, 500}}, {{{0, 500}}, {0, 500}}));
}

}  // namespace
}  // namespace piste::test
