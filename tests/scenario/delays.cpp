// Delays in simulated runs: found by the filter within its sigmas.

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <thread>

#include "piste/consistency/consistency.h"
#include "piste/report/consistency_text.h"
#include "piste/trial/ensemble.h"
#include "support/scenario.h"
#include "support/thorough.h"

namespace piste::test {
namespace {

constexpr double kOfVelocities = 0.2, kOfAttitudes = 0.015;  // s

// Velocities and attitudes that come late. The filter is told delays that are drawn about these with its priors.
Scenario late_scenario() {
  Scenario s = suite_scenario("bicycle_l1l2_attitude");
  shorten(s, 10, 35, 2);
  s.gnss[s.replay.gnss.front()].velocity_delay = kOfVelocities;
  s.attitude[s.replay.attitude.front()].delay = kOfAttitudes;
  s.replay.estimate.push_back(Block::kVelocityDelay);
  s.replay.estimate.push_back(Block::kAttitudeDelay);
  return s;
}

// One alarm in a thousand of these tests, which look at some 50 groups.
void expect_consistent(const Scenario& s) {
  Ensemble ensemble(s);
  ensemble.run(static_cast<std::size_t>(seeds(12, 200)), std::max(1U, std::thread::hardware_concurrency()));
  const ConsistencyReport report = ensemble.sums().report(1 - 1e-3 / 50);
  fmt::print("{}\n", consistency_text(report));
  EXPECT_TRUE(report.consistent());
}

TEST(LateSources, AreFoundAndEveryGroupIsWithinItsBand) { expect_consistent(late_scenario()); }

// Of the IMU's clock neither offset nor drift are known: the filter is told both wrong by a draw of their priors.
Scenario drifting_clock_scenario() {
  Scenario s = suite_scenario("bicycle_l1l2_attitude");
  shorten(s, 10, 80, 2);
  s.replay.estimate.push_back(Block::kGnssDelay);
  s.replay.estimate.push_back(Block::kClockDrift);
  return s;
}

TEST(DriftingClock, IsFoundAndEveryGroupIsWithinItsBand) { expect_consistent(drifting_clock_scenario()); }

void expect_drift_in_the_end(const Scenario& s, std::uint64_t seed) {
  const ComparedRun run = run_trial(s, seed);
  const auto last = std::max_element(run.smoothed.begin(), run.smoothed.end(),
                                     [](const auto& a, const auto& b) { return a.epoch < b.epoch; });
  const int row = run.layout.offset(Block::kClockDrift);
  const double error = last->error(row), sigma = std::sqrt(last->P(row, row));
  fmt::print("clock drift: error {:.1f} ppm, sigma {:.1f} ppm\n", 1e6 * error, 1e6 * sigma);
  EXPECT_LT(std::abs(error), 4 * sigma);
  EXPECT_LT(sigma, 0.5 * Priors{}.clock_drift);
}

TEST(DriftingClock, IsKnownBetterInTheEnd) { expect_drift_in_the_end(drifting_clock_scenario(), 4); }

// Where hardly anything but vibration accelerates the body, the velocities tell a wrong clock if that vibration is not
// seen as it is at the moment.
TEST(DriftingClock, IsFoundInACalmRide) {
  Scenario s = suite_scenario("calm_30min");
  shorten(s, 30, 600, 10);
  s.replay.estimate.push_back(Block::kGnssDelay);
  s.replay.estimate.push_back(Block::kClockDrift);
  for (std::uint64_t seed = 1; seed <= 4; ++seed) expect_drift_in_the_end(s, seed);
}

TEST(LateSources, AreKnownToMillisecondsInTheEnd) {
  const ComparedRun run = run_trial(late_scenario(), 3);
  for (const auto* samples : {&run.filtered, &run.smoothed}) {
    const auto last = std::max_element(samples->begin(), samples->end(),
                                       [](const auto& a, const auto& b) { return a.epoch < b.epoch; });
    for (const Block block : {Block::kVelocityDelay, Block::kAttitudeDelay}) {
      const int row = run.layout.offset(block);
      const double error = last->error(row), sigma = std::sqrt(last->P(row, row));
      fmt::print("{}: error {:.5f} s, sigma {:.5f} s\n", info(block).name, error, sigma);
      EXPECT_LT(std::abs(error), 4 * sigma) << info(block).name;
      EXPECT_LT(sigma, 0.005) << info(block).name;
    }
  }
}

}  // namespace
}  // namespace piste::test
