#include "search/settling.h"

#include <gtest/gtest.h>

#include <cmath>
#include <utility>

#include "search/contradiction.h"
#include "support/simulated_case.h"

namespace piste::test {
namespace {

struct Told {
  explicit Told(Case of = make_case("easy_ski", 40, 1)) : run(std::move(of)) {}

  Case run;
  Recording recording = run.simulation.recording(0);
  bool find_clock = true;
  Calibration calibration{.lever_arm = run.options.gnss[0].lever_arm,
                          .lever_arm_sigma = Vector3d::Constant(0.01),
                          .clock_offset = run.conditioning.imu.clock_offset,
                          .clock_sigma = 0.01,
                          .clock_drift = run.conditioning.imu.clock_drift,
                          .sensor = run.options.sensor};

  WholeLog log() const { return {recording, run.conditioning, run.options, std::nullopt, find_clock}; }
  std::optional<Calibration> settle() const { return settled(log(), calibration); }
};

TEST(Settling, LeavesWhatHolds) {
  const Told told;
  const auto found = told.settle();
  ASSERT_TRUE(found);
  EXPECT_EQ(found->sigma_scales.position, 1);
  EXPECT_EQ(found->sigma_scales.velocity, 1);
  EXPECT_NEAR(found->clock_offset, told.calibration.clock_offset, 1e-3);
}

// A receiver that claims a third of its errors: its sigmas grow until the gate refuses three fixes in a hundred at
// most, as the search has seen all of this short run. No more is asked for.
TEST(Settling, SigmasThatRefuseFixesGrow) {
  Told told;
  scale_sigmas(told.recording.gnss.front().fixes, {.position = 1.0 / 3, .velocity = 1.0 / 3});
  const auto found = told.settle();
  ASSERT_TRUE(found);
  EXPECT_GT(found->sigma_scales.position, 1.5);
  EXPECT_GT(found->sigma_scales.velocity, 1.5);
  EXPECT_LT(found->sigma_scales.position, 4.5);
  EXPECT_LT(found->sigma_scales.velocity, 4.5);
}

// One position in twenty is half a metre off, with a sigma of centimetres: to refuse them costs less than sigmas with
// which the others say little.
TEST(Settling, SigmasDoNotGrowForTails) {
  Told told;
  std::vector<GeodeticFix>& fixes = told.recording.gnss.front().fixes;
  constexpr double kNorth = 0.5 / 6.371e6;  // rad
  for (std::size_t i = 10; i < fixes.size(); i += 20) fixes[i].position.latitude += kNorth;
  const auto found = told.settle();
  ASSERT_TRUE(found);
  EXPECT_EQ(found->sigma_scales.position, 1);
}

TEST(Settling, TheClockTakesTheDelayOfTheFixes) {
  Told told;
  told.calibration.clock_offset += 0.015;
  const auto found = told.settle();
  ASSERT_TRUE(found);
  EXPECT_NEAR(found->clock_offset, told.run.conditioning.imu.clock_offset, 1e-3);
}

TEST(Settling, AClockThatIsKnownStays) {
  Told told;
  told.calibration.clock_offset += 0.015;
  told.find_clock = false;
  const auto found = told.settle();
  ASSERT_TRUE(found);
  EXPECT_EQ(found->clock_offset, told.calibration.clock_offset);
}

// A clock that gains 300 ppm over 240 s is off by 36 ms at either end, and its drift is told to some 10 ppm.
TEST(Settling, TheClockTakesTheDriftThatTheWholeLogTells) {
  Told told(make_case("easy_ski", 40, 1, [](Scenario& s) { s.motion.run = 240; }));
  told.calibration.clock_drift += 3e-4;
  const auto found = told.settle();
  ASSERT_TRUE(found);
  EXPECT_GT(found->clock_drift_sigma, 0);
  EXPECT_LT(found->clock_drift_sigma, 2e-5);
  EXPECT_NEAR(found->clock_drift, told.run.conditioning.imu.clock_drift, 4 * found->clock_drift_sigma);
}

// Where the fixes would have the clock drift by 800 ppm, which none does, it has no drift.
TEST(Settling, ADriftThatNoClockHasIsNone) {
  Told told(make_case("easy_ski", 40, 2, [](Scenario& s) { s.motion.run = 240; }));
  const double first = told.recording.imu.time.front();
  for (double& t : told.recording.imu.time) t += 8e-4 * (t - first);
  const auto found = told.settle();
  ASSERT_TRUE(found);
  EXPECT_EQ(found->clock_drift, 0);
  EXPECT_EQ(found->clock_drift_sigma, 0);
}

// Fixes that few offsets of the clock contradict leave it as unsure as these are apart.
TEST(Settling, TheSpreadOfTheClockStays) {
  Told told;
  told.calibration.clock_spread = 0.3;
  const auto found = told.settle();
  ASSERT_TRUE(found);
  EXPECT_GT(found->clock_sigma, 0.3);
}

// Velocities as of a place half a metre ahead of where the positions are, as a receiver makes them that smooths.
TEST(Settling, VelocitiesThatContradictThePositionsShow) {
  Told told;
  const auto contradict = [&] { return velocities_contradict(told.log(), told.calibration); };
  EXPECT_FALSE(contradict());
  const Truth& body = told.run.simulation.bodies[0];
  for (GeodeticFix& fix : told.recording.gnss.front().fixes) {
    constexpr double kStep = 0.01;  // s
    const auto ahead = [&](double t) -> Vector3d { return body.at(t).q_wb * Vector3d(0.5, 0, 0); };
    if (fix.velocity) fix.velocity->value += (ahead(fix.time + kStep) - ahead(fix.time - kStep)) / (2 * kStep);
  }
  EXPECT_TRUE(contradict());
}

// Velocities with a lasting error that leads 15 m away, and positions whose errors are stated to be slow, so that they
// follow: no innovation shows it.
TEST(Settling, VelocitiesThatLeadAwayFromSlowPositionsShow) {
  Told told(make_case("montecarlo/calm_30min", 40, 3, [](Scenario& s) {
    s.motion.run = 240;
    s.gnss[0].rate = 2;
    s.gnss[0].position_noise = {0.1, 0.1, 0.2};
    s.gnss[0].position_drift = GaussMarkov{{0.5, 0.5, 1}, 90};
    s.gnss[0].velocity_noise = {0.05, 0.05, 0.1};
  }));
  told.calibration.drift = PositionDrift::of_share(Vector3d::Constant(0.5 / std::hypot(0.1, 0.5)), 90);
  const auto contradict = [&] { return velocities_contradict(told.log(), told.calibration); };
  EXPECT_FALSE(contradict());
  for (GeodeticFix& fix : told.recording.gnss.front().fixes) {
    if (fix.velocity) fix.velocity->value.y() += 0.06;
  }
  EXPECT_TRUE(contradict());
}

// A rider who sways, and one who looks along the path: the constraint of a car takes the swaying for a wrong scale.
TEST(Settling, AVehicleThatContradictsTheFixesShows) {
  const auto contradicts = [](double sways) {
    Told told(make_case("montecarlo/calm_30min", 40, 1, [sways](Scenario& s) {
      s.motion.run = 300;
      s.motion.balance_rate *= sways;
      s.gnss[0].rate = 4;
      s.gnss[0].position_noise = {0.4, 0.4, 0.8};
      s.gnss[0].velocity_noise = {0.06, 0.06, 0.1};
    }));
    told.calibration.sensor.gyro.scale = 0.03;
    WholeLog log = told.log();
    log.vehicle.emplace();
    return vehicle_contradicts(log, told.calibration);
  };
  EXPECT_TRUE(contradicts(4));
  EXPECT_FALSE(contradicts(0.01));
}

// Of a drift that was taken for ten times what it is, more motion tells better; a minute is not searched again.
TEST(Settling, MoreMotionTellsTheDriftBetter) {
  const auto drift_after = [](double run) -> std::optional<double> {
    Told told(make_case("easy_ski", 40, 1, [run](Scenario& s) { s.motion.run = run; }));
    told.calibration.sensor.gyro.drift.sigma *= 10;
    const auto before = told.settle();
    EXPECT_TRUE(before);
    const auto found = retuned(told.log(), *before, 2);
    if (!found) return std::nullopt;
    return found->sensor.gyro.drift.sigma / told.run.options.sensor.gyro.drift.sigma;
  };
  EXPECT_FALSE(drift_after(60));
  const auto ratio = drift_after(400);
  ASSERT_TRUE(ratio);
  EXPECT_GT(*ratio, 0.3);
  EXPECT_LT(*ratio, 3);
}

TEST(Settling, SaysWhereNoFilterRuns) {
  Told told;
  told.recording.gnss.front().fixes.clear();
  EXPECT_FALSE(told.settle());
}

}  // namespace
}  // namespace piste::test
