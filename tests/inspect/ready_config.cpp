// What a configuration is told of a calibration: as much as the motion told, and no more.

#include <gtest/gtest.h>

#include <cmath>
#include <string>

#include "piste/inspect/inspection.h"

namespace piste::test {
namespace {

InspectedLog log_of(LogKind kind, const std::string& file) {
  InspectedLog log;
  log.log.file = file;
  log.guess.emplace();
  log.guess->kind = kind;
  return log;
}

// An IMU that counts some 10 m/s² and a receiver with velocities, which the filter took.
Inspection calibrated(const Calibration& found) {
  Inspection inspection;
  InspectedLog imu = log_of(LogKind::kImu, "imu.csv"), gnss = log_of(LogKind::kGnss, "gnss.csv");
  imu.imu_health.emplace();
  imu.imu_health->sampling.interval = 0.01;
  imu.imu_health->force = 10.6;
  gnss.gnss_health.emplace();
  gnss.gnss_health->velocities = 100;
  gnss.calibration = found;
  inspection.logs = {imu, gnss};
  return inspection;
}

Calibration calibration() {
  Calibration found;
  found.lever_arm = {1, 2, 3};
  found.lever_arm_sigma.setConstant(0.1);
  found.used = 1000;
  return found;
}

std::string config_of(const Calibration& found) {
  return ready_config(calibrated(found), ".", "sensor.yaml").value_or("none");
}

bool contains(const std::string& text, const std::string& part) { return text.find(part) != std::string::npos; }

TEST(ReadyConfig, LeverArmAsTheMotionHasIt) {
  Calibration found = calibration();
  EXPECT_TRUE(contains(config_of(found), "lever_arm: 1.00 2.00 3.00 m ")) << config_of(found);
  EXPECT_TRUE(contains(config_of(found), "priors: {lever_arm: 0.5 m")) << config_of(found);
  found.lever_arm_sigma.y() = 0.6;
  EXPECT_TRUE(contains(config_of(found), "lever_arm: 0 0 0 m ")) << "it is hardly told\n" << config_of(found);
  EXPECT_TRUE(contains(config_of(found), "priors: {lever_arm: 1 m")) << config_of(found);
}

// What was found and is not written is said beside the key.
TEST(ReadyConfig, SaysWhyALeverArmThatWasFoundIsNotWritten) {
  Calibration found = calibration();
  found.lever_arm_sigma.y() = 0.6;
  EXPECT_TRUE(contains(config_of(found), "too roughly to be used: 1.00 2.00 3.00 m +- 0.10 0.60 0.10 ("))
      << config_of(found);
  found.rejected = 500;
  EXPECT_TRUE(contains(config_of(found), "The filter rejected 500 of 1500 measurements")) << config_of(found);
  Inspection without = calibrated(found);
  without.logs[1].calibration.reset();
  const std::string config = ready_config(without, ".", "sensor.yaml").value_or("none");
  EXPECT_TRUE(contains(config, "    lever_arm: 0 0 0 m            # measure it")) << config;
  EXPECT_FALSE(contains(config, "roughly")) << config;
}

// A column that is there is not called missing.
TEST(ReadyConfig, SaysWhereTheSigmaOfVelocitiesIsFrom) {
  Inspection inspection = calibrated(calibration());
  inspection.logs[1].log.sigma_velocity = Vector3d::Constant(0.5);
  const auto config = [&] { return ready_config(inspection, ".", "sensor.yaml").value_or("none"); };
  EXPECT_TRUE(contains(config(), "sigma_velocity: 0.5 m/s         # the log has none")) << config();
  inspection.logs[1].coarse_velocity_sigma = 20;
  EXPECT_TRUE(contains(config(), "# measured: the log states 20 m/s for all")) << config();
}

// What is advised of a delay is what is written.
TEST(ReadyConfig, TheDelayThatIsWritten) {
  Calibration found = calibration();
  found.velocity_delay = 0.1;
  found.velocity_delay_sigma = 0.002;
  Inspection inspection = calibrated(found);
  EXPECT_EQ(written_velocity_delay(inspection, inspection.logs[1]), 0.1);
  EXPECT_TRUE(uses_velocities(inspection.logs[1]));
  inspection.logs[1].calibration->velocities_contradict = true;
  EXPECT_FALSE(written_velocity_delay(inspection, inspection.logs[1]));
  EXPECT_FALSE(uses_velocities(inspection.logs[1]));
  EXPECT_FALSE(contains(ready_config(inspection, ".", "sensor.yaml").value_or(""), "velocity_delay:"));
}

// What is advised is accepted where it is added to what is written.
TEST(ReadyConfig, AdvisesWhatItWrites) {
  Calibration found = calibration();
  found.velocity_delay = 0.13;
  found.velocity_delay_sigma = 0.002;
  Inspection inspection = calibrated(found);
  inspection.logs[1].gnss_health->velocity.emplace();
  inspection.logs[1].gnss_health->velocity->delay = 0.128;
  inspection.logs[1].gnss_health->velocity->sigma_delay = 0.001;
  const auto advice = [&](const std::string& file) {
    inspection.suspicions = {{LogFault::kVelocityDelay, file, "they come late", "?"}};
    advise_as_written(inspection);
    return inspection.suspicions[0].remedy;
  };
  for (const char* file : {"imu.csv", "gnss.csv"}) {
    EXPECT_TRUE(contains(advice(file), "`velocity_delay: 0.130 s`")) << advice(file);
  }
  EXPECT_TRUE(contains(ready_config(inspection, ".", "sensor.yaml").value_or(""), "velocity_delay: 0.130 s "));
  inspection.logs[1].calibration->velocities_contradict = true;
  EXPECT_TRUE(contains(ready_config(inspection, ".", "sensor.yaml").value_or(""), "use: position  "));
  for (const char* file : {"imu.csv", "gnss.csv"}) {
    EXPECT_TRUE(contains(advice(file), "leaves the velocities out (`use: position`)")) << advice(file);
    EXPECT_TRUE(contains(advice(file), "`use: position velocity` and `velocity_delay: 0.128 s`")) << advice(file);
  }
}

// The same velocities at the same rows of the IMU, whatever clock is written.
TEST(ReadyConfig, VelocitiesAreWhereTheyAreInTheImusLog) {
  Calibration found = calibration();
  found.clock_offset = 0.03;
  found.clock_sigma = 0.01;
  found.velocity_delay = 0.1;
  found.velocity_delay_sigma = 0.002;
  EXPECT_TRUE(contains(config_of(found), "clock: {offset: 0.0300 s}")) << config_of(found);
  EXPECT_TRUE(contains(config_of(found), "velocity_delay: 0.100 s ")) << config_of(found);
  EXPECT_TRUE(contains(config_of(found), "gnss_delay: 0.05 s, velocity_delay: 0.01 s}")) << config_of(found);
  found.clock_sigma = 0.05;
  EXPECT_FALSE(contains(config_of(found), "clock:")) << "too little is told of it\n" << config_of(found);
  EXPECT_TRUE(contains(config_of(found), "velocity_delay: 0.070 s ")) << config_of(found);
}

// Where the motions beside each other tell the clock by 0.6 s, and the filter by 0.04 s, it is the filter's; a
// receiver's two times tell it better than the filter, unless that is sure of another one.
TEST(ReadyConfig, TheClockIsThatOfTheSurest) {
  Calibration found = calibration();
  found.clock_offset = 12.30;
  found.clock_sigma = 0.04;
  Inspection inspection = calibrated(found);
  const auto clock = [&inspection] { return guess_conditioning(inspection).clock_offset; };
  EXPECT_EQ(clock(), 12.30) << "nothing was compared, and the filter knows it";
  LogMatch match;
  match.clock.emplace();
  match.clock->offset = 15;
  match.clock->sigma = 0.6;
  inspection.matches = {{0, 1, match}};
  EXPECT_EQ(clock(), 12.30);
  inspection.matches[0].match.clock->sigma = 0.001;
  EXPECT_EQ(clock(), 15);
  inspection.logs[0].imu.time = {1000, 1000.01};
  inspection.logs[0].log.columns.emplace();
  inspection.logs[0].log.columns->time.of = TimeScale::kBoot;
  inspection.logs[1].clock.emplace();
  inspection.logs[1].clock->span = {0, 2000};
  inspection.logs[1].clock->offset = 12.35;
  EXPECT_NEAR(clock(), 12.35, 1e-9);
  inspection.logs[1].calibration->clock_sigma = 0.01;
  EXPECT_EQ(clock(), 12.30);
}

// Clocks that agree as logged are no coincidence: an offset or a drift within chance is left to the estimate.
TEST(ReadyConfig, ClocksStayAsLoggedUnlessTheMotionTellsMore) {
  Calibration found = calibration();
  found.clock_offset = 0.0076;
  found.clock_sigma = 0.0105;
  EXPECT_EQ(guess_conditioning(calibrated(found)).clock_offset, 0);
  EXPECT_FALSE(contains(config_of(found), "clock:")) << config_of(found);
  EXPECT_TRUE(contains(config_of(found), "gnss_delay: 0.05 s")) << "and is estimated\n" << config_of(found);
  found.clock_offset = 0.21;
  found.clock_sigma = 0.1;
  EXPECT_EQ(guess_conditioning(calibrated(found)).clock_offset, 0);
  EXPECT_TRUE(contains(config_of(found), "gnss_delay: 0.24 s")) << "as large as one may be that gains too little\n"
                                                                << config_of(found);
  found.clock_offset = 0.25;
  EXPECT_EQ(guess_conditioning(calibrated(found)).clock_offset, 0.25);
  found.clock_offset = 0.0076;
  found.clock_sigma = 0.0105;
  found.clock_drift = 5e-5;
  found.clock_drift_sigma = 3e-5;
  EXPECT_EQ(guess_conditioning(calibrated(found)).clock_drift, 0);
  found.clock_drift_sigma = 1e-5;
  EXPECT_EQ(guess_conditioning(calibrated(found)).clock_drift, 5e-5);
  found.clock_drift_sigma = 0;
  found.clock_offset = 0.0276;
  EXPECT_EQ(guess_conditioning(calibrated(found)).clock_offset, 0.0276);
}

TEST(ReadyConfig, RowsAreInstantsWhereTheMotionTellsSo) {
  Calibration found = calibration();
  EXPECT_TRUE(contains(config_of(found), "sampling: mean "));
  found.instantaneous = true;
  EXPECT_TRUE(contains(config_of(found), "sampling: instant "));
  EXPECT_TRUE(guess_conditioning(calibrated(found)).instantaneous);
}

TEST(ReadyConfig, NumbersHaveNoExponentAndNoughtNoSign) {
  Calibration found = calibration();
  found.lever_arm = {-0.05, -0.001, -0.41};
  found.velocity_delay = -0.0002;
  found.velocity_delay_sigma = 0.001;
  found.sigma_scales.height = 0.0000171;
  found.drift = GaussMarkov{{0.85, 0.85, 1.46}, 347};
  const std::string config = config_of(found);
  EXPECT_TRUE(contains(config, "lever_arm: -0.05 0.00 -0.41 m ")) << config;
  EXPECT_TRUE(contains(config, "velocity_delay: 0.000 s ")) << config;
  EXPECT_TRUE(contains(config, "sigma_height_scale: 0.0000171 ")) << config;
  EXPECT_TRUE(contains(config, "correlation_time: 350 s}")) << config;
}

}  // namespace
}  // namespace piste::test
