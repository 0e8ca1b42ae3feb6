/// Are the sigmas true? The Monte Carlo suite, made short: NEES within its chi-squared band, errors near the bound;
/// and out of the band where the sensor is worse than its file says.

#include "piste/consistency/consistency.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <iterator>
#include <thread>

#include "piste/math/statistics.h"
#include "piste/math/units.h"
#include "piste/report/consistency_text.h"
#include "piste/trial/ensemble.h"
#include "support/places.h"
#include "support/scenario.h"
#include "support/thorough.h"

namespace piste::test {
namespace {

const int kRuns = seeds(24, 200);
// One alarm in a thousand of these ten reports. Each adjusts for its own number of groups.
constexpr double kProbability = 1 - 1e-3 / 10;

ConsistencyReport report_of(const Scenario& scenario, const std::string& title, int runs) {
  Ensemble ensemble(scenario);
  ensemble.run(static_cast<std::size_t>(runs), std::max(1U, std::thread::hardware_concurrency()));
  ConsistencyReport report = ensemble.sums().report(kProbability);
  fmt::print("{}\n{}\n", title, consistency_text(report));
  return report;
}

Scenario short_scenario(const std::string& name) {
  Scenario s = suite_scenario(name);
  shorten(s, 20, 35, 2);
  return s;
}

class Consistent : public ::testing::TestWithParam<const char*> {};

TEST_P(Consistent, EveryGroupIsWithinItsBandAndNearTheBound) {
  const ConsistencyReport report = report_of(short_scenario(GetParam()), GetParam(), kRuns);
  EXPECT_TRUE(report.consistent());
  const auto under_way = static_cast<std::size_t>(Phase::kUnderWay);
  for (const auto* estimator : {&report.filter, &report.smoother}) {
    for (const Block b : {Block::kVelocity, Block::kAttitude}) {
      const BlockAccuracy& found = estimator->blocks[under_way][static_cast<std::size_t>(index_of(b))];
      EXPECT_LT(found.ratio, 1.05 + 3.3 * found.standard_error) << info(b).name;
      EXPECT_GT(found.ratio, 0.95 - 3.3 * found.standard_error) << info(b).name;
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Suite, Consistent,
                         ::testing::Values("ski_l1l2", "ski_l1", "bicycle_l1l2", "bicycle_l1l2_attitude",
                                           "bicycle_aids", "ski_cross_axis"),
                         [](const auto& name) { return std::string(name.param); });

// The test can fail: the same run with half of the noise in the filter's sensor file.
TEST(Inconsistent, WorseSensorLeavesTheBand) {
  const ConsistencyReport report = report_of(short_scenario("ski_worse_sensor"), "ski_worse_sensor", kRuns / 2);
  EXPECT_FALSE(report.consistent());
  const auto under_way = static_cast<std::size_t>(Phase::kUnderWay);
  for (const auto* estimator : {&report.filter, &report.smoother}) {
    EXPECT_GT(estimator->groups[under_way].front().nees, report.bands.front().high);
  }
}

// Cross-axis errors that the sensor file does not state are errors of the filter: innovations do not show them, NEES
// does.
TEST(Inconsistent, CrossAxisErrorsThatAreNotStatedLeaveTheBand) {
  Scenario s = short_scenario("ski_cross_axis");
  ImuSensor& stated = s.replay.sensor;
  stated.gyro.cross_axis = stated.accel.cross_axis = stated.gyro_g_sensitivity = std::nullopt;
  std::erase_if(s.replay.estimate,
                [&](Block b) { return b >= Block::kGyroCrossAxis && b <= Block::kGyroGSensitivity; });
  const ConsistencyReport report = report_of(s, "not stated", kRuns / 2);
  EXPECT_FALSE(report.consistent());
}

// A calm ride, in which motion tells little of the scales: what they follow then is noise, unless it is taken out.
TEST(CalmRide, ScalesAreWithinTheirSigmas) {
  Scenario s = suite_scenario("calm_30min");
  s.motion.rest_before = 20;
  s.motion.run = 900;
  s.motion.rest_after = 5;
  s.replay.end = 905;
  const ConsistencyReport report = report_of(s, "calm", seeds(3, 32));
  EXPECT_TRUE(report.consistent());
}

// On a level road hardly anything but noise tells the lever arm, which the velocities see through the measured rate.
TEST(LevelRoad, TheSmoothedLeverArmIsWithinItsSigmas) {
  Scenario s = suite_scenario("motorway");
  shorten(s, 20, 300, 5);
  s.replay.end = 300;
  s.motion.balance_rate = s.motion.vibration = s.motion.vibration_rate = Vector3d::Zero();
  s.motion.sway_velocity = s.motion.sway_rate = Vector3d::Zero();
  s.motion.turning_rate = 0;
  s.replay.estimate.push_back(Block::kLeverArm);
  const ConsistencyReport report = report_of(s, "level", seeds(16, 64));
  const auto under_way = static_cast<std::size_t>(Phase::kUnderWay);
  const auto group = std::ranges::find(report.groups, "lever_arm", &StateGroup::name) - report.groups.begin();
  ASSERT_LT(group, std::ssize(report.groups));
  const double nees = report.smoother.groups[under_way][static_cast<std::size_t>(group)].nees;
  EXPECT_TRUE(chi_squared_band(0.999, 3, seeds(16, 64)).contains(nees)) << nees;
}

// Of 5 s of motion alone, from any heading: found every time, and never wrong with a small sigma.
TEST(UnknownHeading, IsFoundWithinFiveSeconds) {
  for (const std::string name : {"ski_heading_5s", "bicycle_heading_5s", "ski_heading_l1_5s"}) {
    if (!thorough() && name != "ski_heading_5s") continue;
    const ConsistencyReport report = report_of(suite_scenario(name), name, kRuns / 2);
    EXPECT_TRUE(report.consistent()) << name;
    EXPECT_EQ(report.heading.runs, kRuns / 2) << name;
    EXPECT_LT(report.heading.largest, 5 / kDegreesPerRadian) << name;
    EXPECT_LT(report.heading.largest_ratio, 4) << name;
  }
}

// Seeds whose gyro bias, not yet known, once made the first seconds of rest look like motion: the heading came out
// 130 deg wrong, with 6 deg claimed.
TEST(UnknownHeading, IsNotFoundInARest) {
  Scenario s = read_scenario(source_folder() + "/config/scenarios/giant_slalom.yaml");
  shorten(s, 20, 35, 2);
  s.replay.heading = ReplaySetup::Heading::kAuto;
  for (const std::uint64_t seed : {8U, 16U}) {
    const ComparedRun run = run_trial(s, seed);
    for (const ErrorSample& sample : run.filtered) {
      EXPECT_LT(sample.error.segment<3>(run.layout.offset(Block::kAttitude)).norm(), 10 / kDegreesPerRadian)
          << "seed " << seed << " at " << sample.epoch << " s of the run";
    }
  }
}

}  // namespace
}  // namespace piste::test
