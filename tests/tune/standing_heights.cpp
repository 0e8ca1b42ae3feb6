// Heights that rounding makes stand still, and such that only look like it.

#include "piste/tune/standing_heights.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <vector>

#include "piste/sim/random.h"

namespace piste::test {
namespace {

// Heights of a minute at 10 Hz.
StandingHeights standing(const std::function<double(double)>& height) {
  std::vector<double> heights;
  heights.reserve(600);
  for (int i = 0; i < 600; ++i) heights.push_back(height(0.1 * i));
  return standing_heights(heights);
}

TEST(StandingHeights, AreThoseThatChangeByASteadyStep) {
  const double sigma = 1 / std::sqrt(12);
  const auto climb = [](double t) { return 480.3 + 0.4 * t; };
  const StandingHeights metres = standing([&](double t) { return std::round(climb(t)); });
  EXPECT_NEAR(metres.slow, sigma, 1e-9);
  EXPECT_NEAR(metres.white, 0.5, 1e-9);
  EXPECT_NEAR(metres.sigma(), 2 * sigma, 1e-9);
  EXPECT_TRUE(metres.too_small(0.4));
  EXPECT_FALSE(metres.too_small(0.5));
  const StandingHeights feet = standing([&](double t) { return 0.3048 * std::round(climb(t) / 0.3048 / 2); });
  EXPECT_NEAR(feet.slow, 0.3048 * sigma, 1e-9);
  const StandingHeights over_geoid = standing([&](double t) { return std::round(climb(t)) + 47.31 + 3e-5 * t; });
  EXPECT_NEAR(over_geoid.slow, sigma, 1e-3);
  RandomStream random(1, "heights");
  const StandingHeights between = standing([&](double) { return std::round(480.5 + 0.02 * random.normal()); });
  EXPECT_NEAR(between.slow, sigma, 1e-9) << "to and fro between two";
  EXPECT_NEAR(standing([](double) { return 480; }).slow, sigma, 1e-9) << "a metre, where nothing tells the step";
}

TEST(StandingHeights, AreNotThoseThatRoundingLeavesFree) {
  RandomStream random(1, "heights");
  EXPECT_EQ(standing([&](double t) { return 480 + 0.4 * t + 0.02 * random.normal(); }).slow, 0);
  EXPECT_EQ(standing([&](double) { return std::round(480 + random.normal()); }).slow, 0) << "noise beyond the step";
  EXPECT_EQ(standing([](double t) { return t < 50 ? 480 : 480 + (t - 50) * (t - 50); }).slow, 0) << "held at rest";
  EXPECT_EQ(standing_heights(std::vector<double>{480, 480, 480}).slow, 0) << "too few";
}

TEST(StandingHeights, AreToldFromOtherColouredErrors) {
  EXPECT_TRUE(is_of_heights_alone(StandingHeights{.slow = 0.3}.process()));
  EXPECT_TRUE(is_of_heights_alone(GaussMarkov{1.9 * StandingHeights{.slow = 0.3}.process().sigma, 300}));
  EXPECT_FALSE(is_of_heights_alone(GaussMarkov{{0.1, 0.1, 0.3}, 300}));
}

}  // namespace
}  // namespace piste::test
