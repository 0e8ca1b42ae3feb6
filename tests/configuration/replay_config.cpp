#include "piste/configuration/replay_config.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "piste/core/state_table.h"
#include "piste/math/units.h"
#include "support/text_file.h"

namespace piste {
namespace {

using test::contains;
using test::message_of;
using test::TemporaryFolder;

constexpr const char* kSensor =
    "name: test\n"
    "gyro: {noise: 0.05 deg/s/sqrt(Hz), bias: 0.5 deg/s, scale: 0 ppm, range: 300 deg/s,\n"
    "       drift: {process: gauss_markov, sigma: 0.01 deg/s, correlation_time: 200 s}}\n"
    "accel: {noise: 200 ug/sqrt(Hz), bias: 0.05 m/s^2, scale: 20000 ppm, range: 2 g, drift: {process: none}}\n";
const std::string kImu = "imu:\n  file: imu.csv\n  sensor: sensor.yaml\n";
const std::string kGnss = "gnss:\n  file: gnss.csv\n  lever_arm: -0.06 0.03 -0.42 m\n";

struct ReplayConfigTest : ::testing::Test {
  TemporaryFolder folder;
  ReplayConfigTest() {
    folder.write("sensor.yaml", kSensor);
    folder.write("imu.csv",
                 "time_s,gyro_x_rad_s,gyro_y_rad_s,gyro_z_rad_s,accel_x_m_s2,accel_y_m_s2,accel_z_m_s2\n"
                 "1,0,0,0,0,0,-9.8\n2,0,0,0,0,0,-9.8\n");
    folder.write(
        "gnss.csv",
        "time_s,latitude_deg,longitude_deg,height_m,sigma_north_m,sigma_east_m,sigma_down_m\n1,46,7,1600,1,1,1\n");
    folder.write(
        "second.csv",
        "time_s,latitude_deg,longitude_deg,height_m,sigma_north_m,sigma_east_m,sigma_down_m\n2,46,7,1600,1,1,1\n");
    folder.write("attitude.csv",
                 "time_s,roll_deg,pitch_deg,heading_deg,sigma_roll_deg,sigma_pitch_deg,sigma_heading_deg\n"
                 "1,0,0,0,0.3,0.4,1\n2,0,0,0,0.3,0.4,7\n");
    folder.write("second_attitude.csv", "");
  }
  ReplayConfig read(const std::string& text) const { return read_replay_config(folder.write("run.yaml", text)); }
  std::string refused(const std::string& text) {
    return message_of<ConfigError>([&] { read(text); });
  }
};

bool has(const ReplayConfig& config, Block block) {
  const auto& e = config.filter.estimate;
  return std::find(e.begin(), e.end(), block) != e.end();
}

// Each receiver has a slow error of its own, in m or as a share of its sigmas.
TEST_F(ReplayConfigTest, SlowErrorsOfReceivers) {
  const auto with = [&](const std::string& first, const std::string& second) {
    return kImu + "gnss:\n  - {file: gnss.csv, drift: " + first + "}\n  - {file: second.csv, drift: " + second + "}\n";
  };
  const ReplayConfig two =
      read(with("{share: 0.7, correlation_time: 60 s}", "{sigma: 1 1 2 m, correlation_time: 9 s}"));
  const GnssOptions &first = two.filter.gnss[0], &second = two.filter.gnss[1];
  EXPECT_TRUE(first.drift->of_stated);
  EXPECT_EQ(first.drift->sigma, Vector3d(0.7, 0.7, 0.7));
  EXPECT_EQ(first.drift->correlation_time, 60);
  EXPECT_FALSE(second.drift->of_stated);
  EXPECT_EQ(second.drift->sigma, Vector3d(1, 1, 2));
  EXPECT_TRUE(has(two, position_drift_block(0, true)));
  EXPECT_TRUE(has(two, position_drift_block(1, false)));
  EXPECT_FALSE(has(two, Block::kGnssPositionDrift));

  const ReplayConfig other = read(with("{share: 0.5 0.6 0.9, correlation_time: 60 s}", "none"));
  EXPECT_EQ(other.filter.gnss[0].drift->sigma, Vector3d(0.5, 0.6, 0.9));
  EXPECT_FALSE(other.filter.gnss[0].white);
  EXPECT_FALSE(other.filter.gnss[1].drift);
  EXPECT_TRUE(other.filter.gnss[1].white);

  for (const auto& [drift, says] :
       {std::pair("{share: 1, correlation_time: 60 s}", "below 1"),
        std::pair("{share: 0, correlation_time: 60 s}", "above 0"),
        std::pair("{share: 0.7 0.7, correlation_time: 60 s}", "north, east and down"),
        std::pair("{share: 0.7 m, correlation_time: 60 s}", "one number is expected"),
        std::pair("{share: 0.7, correlation_time: 0 s}", "above zero"),
        std::pair("{share: 0.7, sigma: 1 1 1 m, correlation_time: 60 s}", "either"), std::pair("white", "none")}) {
    const std::string refusal = refused(with("none", drift));
    EXPECT_TRUE(contains(refusal, "run.yaml:6: ")) << refusal;
    EXPECT_TRUE(contains(refusal, says)) << refusal;
  }
}

// What a sensor file states of cross-axis errors is estimated if it is named, and else considered
// (filter/considered.h).
TEST_F(ReplayConfigTest, CrossAxisErrorsAreEstimatedIfNamed) {
  folder.write("skewed.yaml",
               "name: test\n"
               "gyro: {noise: 0.05 deg/s/sqrt(Hz), bias: 0.5 deg/s, cross_axis: 3000 ppm, g_sensitivity: 0.1 deg/s/g}\n"
               "accel: {noise: 200 ug/sqrt(Hz), bias: 0.05 m/s^2, cross_axis: 3000 ppm}\n");
  const std::string imu = "imu: {file: imu.csv, sensor: skewed.yaml}\n";
  const ReplayConfig silent = read(imu + kGnss + "estimate: [gyro_bias]\n");
  EXPECT_EQ(silent.filter.estimate, std::vector{Block::kGyroBias});
  const ReplayConfig named = read(imu + kGnss + "estimate: [gyro_cross_axis, accel_cross_axis, gyro_g_sensitivity]\n");
  EXPECT_EQ(named.filter.estimate,
            (std::vector{Block::kGyroCrossAxis, Block::kAccelCrossAxis, Block::kGyroGSensitivity}));
  const ReplayConfig square = read(kImu + kGnss + "estimate: [gyro_bias, gyro_cross_axis]\n");
  EXPECT_EQ(square.filter.estimate, std::vector{Block::kGyroBias}) << "a file that is silent states none";
}

TEST_F(ReplayConfigTest, RateOfTheAttitudeThatIsWritten) {
  EXPECT_EQ(read(kImu + kGnss).rates.attitude, 10);
  EXPECT_EQ(read(kImu + kGnss + "attitude_output: {rate: 25 Hz}\n").rates.attitude, 25);
  EXPECT_TRUE(contains(refused(kImu + kGnss + "attitude_output: {rate: 0 Hz}\n"), "run.yaml:7"));
  EXPECT_TRUE(contains(refused(kImu + kGnss + "attitude_output: {rate: 10 s}\n"), "frequency"));
}

TEST_F(ReplayConfigTest, RatesOfTheFiles) {
  const OutputRates usual = read(kImu + kGnss).rates;
  EXPECT_EQ(usual.navigation, 0);  // that of the IMU
  EXPECT_EQ(usual.biases, 10);
  const OutputRates rates = read(kImu + kGnss + "output: {rate: 5 Hz, biases: imu, covariance: none}\n").rates;
  EXPECT_EQ(rates.navigation, 5);
  EXPECT_EQ(rates.biases, 0);
  EXPECT_TRUE(contains(refused(kImu + kGnss + "output: {rate: 5}\n"), "run.yaml:7: rate"));
  EXPECT_TRUE(contains(refused(kImu + kGnss + "output: {biases: 0 Hz}\n"), "or `imu` for every epoch"));
  EXPECT_TRUE(contains(refused(kImu + kGnss + "output: {covariance: half}\n"), "none of: none, full"));
}

TEST_F(ReplayConfigTest, TheWholeContract) {
  const std::string text =
      "imu:\n  file: ../" + folder.path().filename().string() +
      "/imu.csv\n  format: csv\n  sensor: sensor.yaml\n  axes: +y -x +z\n  sampling: instant\n"
      "  clock: {offset: 20 ms, drift: 15 ppm}\n"
      "gnss:\n  - file: gnss.csv\n    format: csv\n    lever_arm: -0.06 0.03 -0.42 m\n    use: position velocity\n"
      "    drift: {sigma: 0.4 0.4 0.7 m, correlation_time: 60 s}\n  - {file: second.csv, use: position}\n"
      "attitude:\n  - file: attitude.csv\n    correlation_time: 60 s\n"
      "initial: {heading: 123.4 deg, sigma: 3 deg}\n"
      "estimate: [gyro_bias, accel_bias, gyro_drift, accel_drift, gyro_scale, accel_scale, boresight]\n"
      "rest: {detect: false, sigma_velocity: 2 cm/s}\ngate: 0.99\nsmoother: none\nspan: {start: 100 s, end: 200 s}\n"
      "outages: [[120, 15], [150 s, 10 s]]\n";
  const ReplayConfig config = read(text);
  EXPECT_EQ(config.echo, text);
  EXPECT_EQ(config.imu.sensor.name, "test");
  EXPECT_EQ(config.conditioning.imu.R_bs(0, 1), 1);
  EXPECT_TRUE(config.conditioning.imu.instantaneous);
  EXPECT_EQ(config.conditioning.imu.clock_offset, 0.02);
  EXPECT_DOUBLE_EQ(config.conditioning.imu.clock_drift, 15e-6);
  EXPECT_DOUBLE_EQ(config.conditioning.gyro_range, 300 * kDegree);
  EXPECT_EQ(config.conditioning.span.end, 200);
  EXPECT_EQ(config.conditioning.outages[0].end, 135);
  ASSERT_EQ(config.filter.gnss.size(), 2u);
  EXPECT_EQ(config.filter.gnss[0].lever_arm, Vector3d(-0.06, 0.03, -0.42));
  EXPECT_EQ(config.filter.gnss[0].drift->sigma, Vector3d(0.4, 0.4, 0.7));
  EXPECT_FALSE(config.filter.gnss[1].use_velocity);
  EXPECT_EQ(config.initial.source, InitialHeading::Source::kValue);
  EXPECT_DOUBLE_EQ(config.initial.value, 123.4 * kDegree);
  EXPECT_DOUBLE_EQ(config.initial.sigma, 3 * kDegree);
  EXPECT_FALSE(config.filter.behaviour.rest.detect);
  EXPECT_EQ(config.filter.behaviour.rest.sigma_velocity, 0.02);
  EXPECT_EQ(config.filter.behaviour.trust.gate, 0.99);
  EXPECT_EQ(config.smoother, SmootherKind::kNone);
  // The sensor has no gyro scale and no accelerometer drift; the sources add their coloured errors.
  for (const Block b : {Block::kGyroBias, Block::kAccelBias, Block::kGyroDrift, Block::kAccelScale, Block::kBoresight,
                        Block::kGnssPositionDrift, Block::kAttitudeDrift}) {
    EXPECT_TRUE(has(config, b)) << info(b).name;
  }
  EXPECT_FALSE(has(config, Block::kGyroScale));
  EXPECT_FALSE(has(config, Block::kAccelDrift));
}

TEST_F(ReplayConfigTest, DefaultsOfTheShortestOne) {
  const ReplayConfig config = read(kImu + kGnss);
  EXPECT_EQ(config.initial.source, InitialHeading::Source::kAuto);
  EXPECT_EQ(config.smoother, SmootherKind::kRts);
  EXPECT_FALSE(config.filter.adapt);
  EXPECT_TRUE(config.filter.behaviour.rest.detect);
  EXPECT_TRUE(config.filter.estimate.empty());
  EXPECT_TRUE(config.attitude.empty());
  EXPECT_EQ(config.conditioning.span.end, 0);
}

TEST_F(ReplayConfigTest, Adaptation) {
  EXPECT_FALSE(read(kImu + kGnss + "adapt: false\n").filter.adapt);
  EXPECT_EQ(read(kImu + kGnss + "adapt: true\n").filter.adapt->within, 10);
  const ReplayConfig config = read(kImu + kGnss + "adapt: {within: 4, time: 60 s, imu_time: 2 h}\n");
  EXPECT_EQ(config.filter.adapt->within, 4);
  EXPECT_EQ(config.filter.adapt->time, 60);
  EXPECT_EQ(config.filter.adapt->imu_time, 7200);
}

TEST_F(ReplayConfigTest, BehaviourIsThatOfConditioningAndFilter) {
  const ReplayConfig config = read(kImu + kGnss +
                                   "gaps: {longest: 60 s}\nspikes: {mend: false}\nrest: {shortest: 2 s}\n"
                                   "initial: {hypotheses: 24}\ntrust: {distrust: 20 s}\n");
  EXPECT_EQ(config.conditioning.behaviour.gaps.longest, 60);
  EXPECT_FALSE(config.conditioning.behaviour.spikes.mend);
  EXPECT_EQ(config.conditioning.behaviour.rest.shortest, 2);
  EXPECT_EQ(config.filter.behaviour.start.hypotheses, 24);
  EXPECT_EQ(config.filter.behaviour.trust.distrust, 20);
}

TEST_F(ReplayConfigTest, ReadsTheRecording) {
  const ReplayConfig config = read(kImu + kGnss + "attitude: {file: attitude.csv, correlation_time: 60 s}\n");
  const Recording recording = read_recording(config);
  EXPECT_EQ(recording.imu.time.size(), 2u);
  EXPECT_EQ(recording.gnss.at(0).fixes.size(), 1u);
  EXPECT_EQ(recording.attitude.at(0).fixes.size(), 2u);
}

const std::string kVelocities =
    "time_s,latitude_deg,longitude_deg,height_m,sigma_north_m,sigma_east_m,sigma_down_m,velocity_north_m_s,"
    "velocity_east_m_s,velocity_down_m_s,sigma_velocity_north_m_s,sigma_velocity_east_m_s,sigma_velocity_down_m_s\n"
    "1,46,7,1600,1,1,1,0,0,0,1,1,1\n";

TEST_F(ReplayConfigTest, DelaysOfTheSources) {
  const FilterOptions none = read(kImu + kGnss).filter;
  EXPECT_EQ(none.gnss[0].delay, 0);
  EXPECT_FALSE(none.gnss[0].velocity_delay);
  const FilterOptions one = read(kImu + kGnss + "  delay: 20 ms\n").filter;
  EXPECT_EQ(one.gnss[0].delay, 0.02);
  EXPECT_EQ(one.gnss[0].delay_of_velocity(), 0.02);
  folder.write("gnss.csv", kVelocities);
  const ReplayConfig all = read(kImu + kGnss +
                                "  delay: -0.01 s\n  velocity_delay: 0.128 s\n"
                                "attitude: {file: attitude.csv, delay: 0.0155 s}\n"
                                "estimate: [gnss_delay, velocity_delay, attitude_delay]\n"
                                "priors: {gnss_delay: 1 ms, velocity_delay: 2 ms, attitude_delay: 3 ms}\n");
  EXPECT_EQ(all.filter.gnss[0].delay, -0.01);
  EXPECT_EQ(all.filter.gnss[0].delay_of_velocity(), 0.128);
  EXPECT_EQ(all.filter.attitude[0].delay, 0.0155);
  EXPECT_EQ(all.filter.priors.gnss_delay, 0.001);
  EXPECT_EQ(all.filter.priors.velocity_delay, 0.002);
  EXPECT_EQ(all.filter.priors.attitude_delay, 0.003);
  for (const Block b : {Block::kGnssDelay, Block::kVelocityDelay, Block::kAttitudeDelay}) EXPECT_TRUE(has(all, b));
  EXPECT_EQ(read_recording(all).gnss[0].fixes.size(), 1U);
}

TEST_F(ReplayConfigTest, DelaysOfVelocitiesThatAreNotThere) {
  const auto refused_data = [&](const std::string& more) {
    const ReplayConfig config = read(kImu + kGnss + more);
    return message_of<DataError>([&] { read_recording(config); });
  };
  EXPECT_TRUE(contains(refused_data("  velocity_delay: 0.1 s\n"), "gnss.csv:1: the log has no velocities for"));
  EXPECT_TRUE(contains(refused_data("estimate: [velocity_delay]\n"), "gnss.csv:1: the log has no velocities from"));
}

TEST_F(ReplayConfigTest, ABoresightIsConstantUnlessItIsSaidToChange) {
  const ReplayConfig constant = read(kImu + kGnss + "attitude: {file: attitude.csv}\nestimate: [boresight]\n");
  EXPECT_FALSE(constant.filter.attitude[0].boresight_drift);
  EXPECT_FALSE(has(constant, Block::kBoresightDrift));
  const ReplayConfig changing = read(kImu + kGnss +
                                     "attitude: {file: attitude.csv, boresight: {sigma: 0.1 deg, correlation_time: 100 "
                                     "s}}\nestimate: [boresight]\n");
  EXPECT_TRUE(changing.filter.attitude[0].boresight_drift->sigma.isApprox(Vector3d::Constant(0.1 * kDegree)));
  EXPECT_EQ(changing.filter.attitude[0].boresight_drift->correlation_time, 100);
  EXPECT_TRUE(has(changing, Block::kBoresightDrift));
}

TEST_F(ReplayConfigTest, Magnetometer) {
  const ReplayConfig config = read(kImu + kGnss +
                                   "magnetometer: {sigma: 0.4 uT, hard_iron: 20 uT, soft_iron: 0.1, year: 2026.5,\n"
                                   "  declination: 3 deg, unit: 48 uT, interval: 0.2 s,\n"
                                   "  disturbance: {sigma: 2 uT, correlation_time: 5 s}}\n");
  ASSERT_TRUE(config.filter.magnetometer);
  const MagnetometerOptions& options = *config.filter.magnetometer;
  EXPECT_NEAR(options.sigma, 0.4, 1e-12);
  EXPECT_NEAR(options.hard_iron, 20, 1e-12);
  EXPECT_EQ(options.soft_iron, 0.1);
  EXPECT_TRUE(options.disturbance.sigma.isApprox(Vector3d::Constant(2)));
  EXPECT_EQ(options.disturbance.correlation_time, 5);
  const MagneticConditioning& magnetic = config.conditioning.magnetic;
  EXPECT_EQ(magnetic.year, 2026.5);
  EXPECT_NEAR(magnetic.declination.value(), 3 * kDegree, 1e-12);
  EXPECT_NEAR(magnetic.unit, 48, 1e-9);
  EXPECT_EQ(magnetic.interval, 0.2);
  for (const Block b :
       {Block::kHardIron, Block::kSoftIronX, Block::kSoftIronY, Block::kSoftIronZ, Block::kMagneticDisturbance}) {
    EXPECT_TRUE(has(config, b)) << info(b).name;
  }
  // What has no error is no state.
  const ReplayConfig calibrated = read(kImu + kGnss + "magnetometer: {hard_iron: 0 uT, soft_iron: 0}\n");
  EXPECT_FALSE(has(calibrated, Block::kHardIron) || has(calibrated, Block::kSoftIronX));
}

TEST_F(ReplayConfigTest, VehicleAndItsSensors) {
  folder.write("speed.csv", "time_s,speed_m_s\n1,5\n2,-6\n");
  folder.write("baro.csv", "time_s,pressure_hPa,sigma_pressure_hPa\n1,1013.25,0.1\n2,900,0.1\n");
  folder.write("dual.csv", "time_s,heading_deg,sigma_heading_deg,pitch_deg\n1,90,0.5,1\n");
  const ReplayConfig config = read(kImu + kGnss +
                                   "vehicle: {kind: car, contact: -1 0 0.5 m, mounting: 1 2 3 deg}\n"
                                   "odometer: {file: speed.csv, signed: true}\n"
                                   "barometer: {file: baro.csv}\n"
                                   "heading: {file: dual.csv, baseline: 0 1 0 m}\n");
  ASSERT_TRUE(config.filter.vehicle && config.filter.odometer && config.filter.barometer && config.filter.heading);
  EXPECT_EQ(config.filter.vehicle->contact, Vector3d(-1, 0, 0.5));
  EXPECT_TRUE(config.filter.vehicle->mounting->isApprox(from_euler(kDegree * Vector3d(1, 2, 3))));
  EXPECT_TRUE(config.filter.odometer->is_signed);
  EXPECT_EQ(config.filter.heading->baseline, Vector3d(0, 1, 0));
  for (const Block b :
       {Block::kVehicleMounting, Block::kVehicleContact, Block::kPitchCentre, Block::kDive, Block::kSpringPitch,
        Block::kSideSlip, Block::kCornering, Block::kWheelSlip, Block::kOdometerScale, Block::kBarometerOffset}) {
    EXPECT_TRUE(has(config, b)) << info(b).name;
  }
  const Recording logs = read_recording(config);
  ASSERT_EQ(logs.speed.fixes.size(), 2U);
  EXPECT_EQ(logs.speed.fixes[1].speed, -6);
  EXPECT_EQ(logs.speed.fixes[1].sigma, 0.1);
  ASSERT_EQ(logs.height.fixes.size(), 2U);
  EXPECT_NEAR(logs.height.fixes[0].height, 0, 1e-9);
  EXPECT_NEAR(logs.height.fixes[1].height, 988.5, 0.5);  // of the standard atmosphere's tables
  EXPECT_NEAR(logs.height.fixes[0].sigma, 0.83, 0.01);
  ASSERT_EQ(logs.heading.fixes.size(), 1U);
  EXPECT_NEAR(logs.heading.fixes[0].heading, 90 * kDegree, 1e-12);
  EXPECT_NEAR(logs.heading.fixes[0].pitch.value(), 1 * kDegree, 1e-12);
  EXPECT_NEAR(logs.heading.fixes[0].sigma_pitch, 1 * kDegree, 1e-12);  // twice that of the heading

  const ReplayConfig none = read(kImu + kGnss + "vehicle: off\n");
  EXPECT_FALSE(none.filter.vehicle);
  EXPECT_FALSE(has(none, Block::kVehicleMounting));
  const ReplayConfig bicycle = read(kImu + kGnss + "vehicle: {kind: bicycle, contact: -0.5 0 0.9 m}\n");
  EXPECT_FALSE(bicycle.filter.vehicle->mounting);
  EXPECT_FALSE(has(bicycle, Block::kDive));  // it has no springs

  const auto refused_log = [&](const std::string& text, const std::string& line) {
    folder.write("bad.csv", text);
    const ReplayConfig bad = read(kImu + kGnss + "vehicle: {kind: car}\n" + line);
    return message_of<DataError>([&] { read_recording(bad); });
  };
  EXPECT_TRUE(contains(refused_log("time_s,speed_km_h\n1,5\n", "odometer: {file: bad.csv}\n"), "speed_m_s"));
  EXPECT_TRUE(contains(refused_log("time_s,pressure_hPa\n1,101325\n", "barometer: {file: bad.csv}\n"), "in Pa?"));
  EXPECT_TRUE(contains(refused_log("time_s,height_ft\n1,5\n", "barometer: {file: bad.csv}\n"), "height_m"));
  EXPECT_TRUE(contains(refused_log("time_s,heading_deg,sigma_heading_deg\n1,5,0\n", "heading: {file: bad.csv}\n"),
                       "above zero"));
  EXPECT_TRUE(contains(refused_log("time_s,speed_m_s\n1,5\n2,-6\n", "odometer: {file: bad.csv}\n"),
                       "bad.csv:3: a speed of -6 m/s; of a wheel that is negative backwards, say `signed: true`"));
  EXPECT_TRUE(contains(refused_log("time_s,speed_m_s,sigma\n1,5,0\n", "odometer: {file: bad.csv}\n"),
                       "bad.csv:2: sigma must be above zero; `sigma: 0.1 m/s` in the configuration replaces it"));
  EXPECT_TRUE(contains(refused_log("time_s,heading_deg\n1,5\n2,375\n", "heading: {file: bad.csv}\n"),
                       "bad.csv:3: a heading of 375 deg is out of range"));
  EXPECT_TRUE(contains(refused_log("time_s,heading_deg,pitch_deg\n1,5,95\n", "heading: {file: bad.csv}\n"),
                       "bad.csv:2: a pitch of 95 deg is out of range"));
}

// As of receivers: rows are sorted, those of a time that stood there before are dropped, and both are counted.
TEST_F(ReplayConfigTest, RepairsTheLogsOfOtherSensors) {
  folder.write("speed.csv", "time_s,speed_m_s\n1,5\n3,7\n2,6\n3,8\n");
  folder.write("baro.csv", "time_s,height_m\n2,20\n1,10\n");
  folder.write("dual.csv", "time_s,heading_deg\n1,90\n1,91\n");
  const Recording logs =
      read_recording(read(kImu + kGnss +
                          "vehicle: {kind: car}\nodometer: {file: speed.csv, repair: true}\n"
                          "barometer: {file: baro.csv, repair: true}\nheading: {file: dual.csv, repair: true}\n"));
  ASSERT_EQ(logs.speed.fixes.size(), 3U);
  for (int i = 0; i < 3; ++i) EXPECT_EQ(logs.speed.fixes[static_cast<std::size_t>(i)].speed, 5 + i);
  EXPECT_EQ(logs.speed.repaired.sorted, 1U);
  EXPECT_EQ(logs.speed.repaired.dropped, 1U);
  EXPECT_EQ(logs.height.fixes.front().height, 10);
  EXPECT_EQ(logs.height.repaired.sorted, 1U);
  EXPECT_EQ(logs.heading.fixes.size(), 1U);
  EXPECT_EQ(logs.heading.repaired.dropped, 1U);
}

// `sigma` in the configuration replaces all sigmas of a log, whatever stands there.
TEST_F(ReplayConfigTest, AStatedSigmaReplacesThoseOfOtherSensors) {
  folder.write("speed.csv", "time_s,speed_m_s,sigma_speed_m_s\n1,5,0\n");
  folder.write("dual.csv", "time_s,heading_deg,sigma_heading_deg,pitch_deg,sigma_pitch_deg\n1,90,0,1,0\n");
  const Recording logs = read_recording(read(kImu + kGnss +
                                             "vehicle: {kind: car}\nodometer: {file: speed.csv, sigma: 0.2 m/s}\n"
                                             "heading: {file: dual.csv, sigma: 0.3 deg}\n"));
  EXPECT_EQ(logs.speed.fixes[0].sigma, 0.2);
  EXPECT_NEAR(logs.heading.fixes[0].sigma, 0.3 * kDegree, 1e-12);
  EXPECT_NEAR(logs.heading.fixes[0].sigma_pitch, 0.6 * kDegree, 1e-12);
}

TEST_F(ReplayConfigTest, ReadsTheBatch) {
  const ReplayConfig config =
      read(kImu + kGnss + "smoother: batch\nbatch: {loss: barron, bound: 0.99, spacing: 500 ms}\n");
  EXPECT_EQ(config.smoother, SmootherKind::kBatch);
  EXPECT_EQ(config.batch.loss, BatchLoss::kBarron);
  EXPECT_EQ(config.batch.bound, 0.99);
  EXPECT_DOUBLE_EQ(config.batch.longest_interval, 0.5);
}

TEST_F(ReplayConfigTest, RefusesWithTheLineAndTheRemedy) {
  const std::string base = kImu + kGnss;  // six lines
  const std::tuple<std::string, std::string, std::string> cases[] = {
      {"smother: rts\n", "run.yaml:7: unknown key `smother`", "perhaps `smoother`"},
      {"gate: 0.99\ngate: 0.9\n", "run.yaml:8: key `gate`", "line 7"},
      {"batch: {loss: barron}\n", "run.yaml:7: batch", "smoother: batch"},
      {"smoother: batch\nbatch: {loss: huber}\n", "run.yaml:8: loss", "truncated"},
      {"smoother: batch\nbatch: {spacing: 1}\n", "run.yaml:8: spacing", "no unit"},
      {"smoother: batch\nbatch: {bound: 99.9}\n", "run.yaml:8: bound", "0.999"},
      {"adapt: perhaps\n", "run.yaml:7: adapt", "true"},
      {"adapt: {within: 1}\n", "run.yaml:7: within", "such as 10"},
      {"adapt: {time: 60}\n", "run.yaml:7: time", "no unit"},
      {"adapt: {tim: 60 s}\n", "run.yaml:7: unknown key `tim`", "perhaps `time`"},
      {"gate: 2\n", "run.yaml:7: gate", "0.999"},
      {"estimate: [gyro_biass]\n", "run.yaml:7: estimate: there is no state block `gyro_biass`", "perhaps `gyro_bias`"},
      {"estimate: [boresight]\n", "run.yaml:7: estimate: boresight needs", "`attitude:` source"},
      {"estimate: [gnss_position_drift]\n", "run.yaml:7", "a `gnss:` source with a drift"},
      {"estimate: [gyro_bias, gyro_bias]\n", "run.yaml:7", "twice"},
      {"estimate: [attitude_delay]\n", "run.yaml:7: estimate: attitude_delay needs", "`attitude:` source"},
      {"  use: position\nestimate: [velocity_delay]\n", "run.yaml:8: estimate: velocity_delay needs",
       "whose velocities are used"},
      {"  delay: 0.1\n", "run.yaml:7: delay: `0.1` has no unit", "s"},
      {"  velocity_delay: 128\n", "run.yaml:7: velocity_delay: `128` has no unit", "s"},
      {"  use: position\n  velocity_delay: 0.1 s\n", "run.yaml:8: velocity_delay: the velocities of this receiver",
       "leave the key out"},
      {"attitude: {file: attitude.csv, delay: 15}\n", "run.yaml:7: delay: `15` has no unit", "s"},
      {"initial: {heading: north}\n", "run.yaml:7: heading: `north` is none of", "auto"},
      {"initial: {heading: 12}\n", "run.yaml:7: heading: `12` has no unit", "1.5 deg"},
      {"initial: {heading: from_attitude}\n", "run.yaml:7", "`attitude:` source"},
      {"span: {start: 10 s, end: 5 s}\n", "run.yaml:7: end", "after start"},
      {"outages: [[10, 0]]\n", "run.yaml:7: outages", "[start, length]"},
      {"outages: [10, 5]\n", "run.yaml:7: outages", "[100 s, 15 s]"},
      {"rest: {detect: maybe}\n", "run.yaml:7: detect: `maybe` is none of", "true, false"},
      {"attitude: {file: attitude.csv, correlation_time: 60}\n", "run.yaml:7: correlation_time", "`60 s`"},
      {"attitude: {file: attitude.csv, boresight: {sigma: 0 deg, correlation_time: 9 s}}\n", "run.yaml:7: sigma",
       "`0.1 deg`"},
      {"attitude: {file: attitude.csv, boresight: {sigma: 1 deg, correlation_time: 0 s}}\n",
       "run.yaml:7: correlation_time", "constant"},
      {"attitude: [{file: attitude.csv, boresight: {sigma: 1 deg, correlation_time: 9 s}},\n"
       "           {file: second_attitude.csv, boresight: {sigma: 1 deg, correlation_time: 9 s}}]\n",
       "run.yaml:7: attitude boresight", "one source at most"},
      {"attitude: {file: attitude.csv}\nestimate: [boresight_drift]\n", "run.yaml:8: estimate: boresight_drift needs",
       "boresight: {sigma, correlation_time}"},
      {"vehicle: {kind: ski}\n", "run.yaml:7: kind: `ski` is none of", "car, bicycle"},
      {"vehicle: on\n", "run.yaml:7: vehicle: a map is expected", "`off`"},
      {"vehicle: {kind: car, contact: 0 0 1}\n", "run.yaml:7: contact", "no unit"},
      {"vehicle: {kind: car, contakt: 0 0 1 m}\n", "run.yaml:7: unknown key `contakt`", "perhaps `contact`"},
      {"vehicle: {kind: car, sigma_mounting: 1 1 1 deg}\n", "run.yaml:7: sigma_mounting", "leave the key out"},
      {"vehicle: {kind: bicycle}\n", "run.yaml:7: `contact` is missing", "rear wheel"},
      {"estimate: [dive]\n", "run.yaml:7: estimate: dive needs", "`vehicle:`"},
      {"attitude: {file: missing.csv}\n", "run.yaml:7: file: there is no file", "relative to the folder"},
  };
  for (const auto& [line, problem, remedy] : cases) {
    const std::string message = refused(base + line);
    EXPECT_TRUE(contains(message, problem)) << line;
    EXPECT_TRUE(contains(message, remedy)) << line;
  }
}

TEST_F(ReplayConfigTest, RefusesInTheSources) {
  EXPECT_TRUE(contains(refused(kGnss), "run.yaml:1: key `imu` is missing"));
  EXPECT_TRUE(
      contains(refused(kImu + "estimate: [lever_arm]\n"), "run.yaml:4: estimate: lever_arm needs a `gnss:` source"));
  EXPECT_TRUE(contains(refused(kImu + "  format: nmea\n"), "run.yaml:4: format: `nmea` is none of"));
  EXPECT_TRUE(contains(refused(kImu + kGnss + "  format: nmea\n  sigma: 2 0 4 m\n"),
                       "run.yaml:8: sigma: must be above zero on each axis, such as `2 2 4 m`"));
  EXPECT_TRUE(contains(refused(kImu + kGnss + "  format: nmea\n  sigma_velocity: 0 m/s\n"),
                       "run.yaml:8: sigma_velocity: must be above zero"));
  EXPECT_TRUE(contains(refused(kImu + kGnss + "  format: nmea\n  sigma: 2 2 4 deg\n"), "run.yaml:8: sigma"));
  EXPECT_TRUE(contains(refused(kImu + kGnss + "  format: rinex\n"), "run.yaml:7: format: `rinex` is none of"));
  EXPECT_TRUE(contains(refused(kImu + kGnss + "  use: speed\n"), "run.yaml:7: use"));
  EXPECT_TRUE(contains(refused(kImu + "  axes: +x +y -z\n" + kGnss), "run.yaml:4: axes"));
  EXPECT_TRUE(contains(refused(kImu + "gnss: {file: gnss.csv, lever_arm: 1 2 3}\n"),
                       "run.yaml:4: lever_arm: `1 2 3` has no unit"));
  EXPECT_TRUE(contains(refused("imu: {file: imu.csv, sensor: none.yaml}\n"), "run.yaml:1: sensor: there is no file"));
}

TEST_F(ReplayConfigTest, IncrementsAreNoInstantaneousSamples) {
  folder.write("imu.csv",
               "time_s,dtheta_x_rad,dtheta_y_rad,dtheta_z_rad,dvel_x_m_s,dvel_y_m_s,dvel_z_m_s\n"
               "10,0,0,0,0,0,-0.098\n10.01,0,0,0,0,0,-0.098\n");
  const ReplayConfig config = read(kImu + "  sampling: instant\n" + kGnss);
  EXPECT_TRUE(contains(message_of<ConfigError>([&] { read_recording(config); }), "run.yaml:4: sampling"));
}

// A table in memory under the name that the configuration gives gives the recording of a file with the same numbers.
TEST(ReplayConfig, TakesTablesInPlaceOfFiles) {
  const std::vector<double> imu{100, 0.1, 0, 0, 0, 0, -9.8, 100.5, 0.2, 0, 0, 0, 0, -9.8, 101, 0.3, 0, 0, 0, 0, -9.8};
  const std::vector<double> gnss{100.5, 46, 7, 1000, 1, 1, 2};
  const auto columns = [](const std::vector<double>& block, const std::vector<std::string>& names) {
    NumberColumns table{.columns = {}, .rows = block.size() / names.size()};
    for (std::size_t i = 0; i < names.size(); ++i) {
      table.columns.push_back({names[i], block.data() + i, static_cast<std::ptrdiff_t>(names.size())});
    }
    return table;
  };
  const NamedColumns tables{{"imu", columns(imu, {"time_s", "gyro_x_rad_s", "gyro_y_rad_s", "gyro_z_rad_s",
                                                  "accel_x_m_s2", "accel_y_m_s2", "accel_z_m_s2"})},
                            {"gnss", columns(gnss, {"time_s", "latitude_deg", "longitude_deg", "height_m",
                                                    "sigma_north_m", "sigma_east_m", "sigma_down_m"})}};
  const std::string sensor =
      "{name: own, gyro: {noise: 0.05 deg/s/sqrt(Hz), bias: 1 deg/s, drift: {process: none}, scale: 0 ppm}, accel: "
      "{noise: 1 mg/sqrt(Hz), bias: 10 mg, drift: {process: none}, scale: 0 ppm}}";
  const std::string text = "imu: {file: imu, sensor: " + sensor + "}\ngnss: {file: gnss}\n";
  const ReplayConfig config = read_replay_config(Config::parse(text, "keywords", tables));
  EXPECT_EQ(config.filter.sensor.name, "own");
  const Recording recording = read_recording(config);
  EXPECT_EQ(recording.imu.time, (std::vector<double>{100, 100.5, 101}));
  EXPECT_EQ(recording.imu.gyro[2], Vector3d(0.3, 0, 0));
  ASSERT_EQ(recording.gnss.front().fixes.size(), 1U);
  EXPECT_EQ(recording.gnss.front().fixes.front().sigma_position, Vector3d(1, 1, 2));
  EXPECT_THROW(
      read_replay_config(Config::parse("imu: {file: imu, format: imr, sensor: " + sensor + "}\n", "k", tables)),
      ConfigError);
  EXPECT_THROW(read_replay_config(Config::parse("imu: {file: other, sensor: " + sensor + "}\n", "k", tables)),
               ConfigError);
}

}  // namespace
}  // namespace piste
