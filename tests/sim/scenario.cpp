#include "piste/sim/scenario.h"

#include <gtest/gtest.h>
#include <yaml-cpp/yaml.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <iterator>

#include "piste/core/error.h"
#include "piste/io/log_io.h"
#include "piste/math/units.h"
#include "piste/sim/simulation.h"
#include "support/places.h"
#include "support/text_file.h"

namespace piste {
namespace {

const std::filesystem::path kScenarios = test::kSource / "config" / "scenarios";

// Table 5 of the article.
const Vector3d kAccelCorrelation(0.96, 0.33, 0.98), kGyroCorrelation(0.29, 0.48, 0.29);

Scenario shipped(const std::string& name) { return read_scenario(kScenarios / name); }

// The MEMS only, with little rest: all that the signals under way depend on.
Scenario mems_of(const std::string& name) {
  Scenario s = shipped(name);
  s.motion.rest_before = s.motion.rest_after = 2;
  std::erase_if(s.imus, [](const ImuSetup& imu) { return imu.name == "ln200"; });
  s.gnss.clear();
  s.attitude.clear();
  return s;
}

void expect_within(const Vector3d& value, const Vector3d& expected, double tolerance, const std::string& what) {
  for (int i = 0; i < 3; ++i) EXPECT_NEAR(value(i), expected(i), tolerance) << what << " axis " << i;
}

TEST(Scenario, SkiSignalsGiveTheCorrelationsOfTheArticle) {
  const Scenario s = mems_of("ski.yaml");
  for (const std::uint64_t seed : {1u, 2u}) {
    const Simulation run = simulate(s, seed);
    for (std::size_t i = 0; i < run.imus.size(); ++i) {
      expect_within(bias_scale_correlation(run.imus[i].accel), kAccelCorrelation, 0.05, s.imus[i].name + " accel");
      expect_within(bias_scale_correlation(run.imus[i].gyro), kGyroCorrelation, 0.15, s.imus[i].name + " gyro");
    }
  }
}

// The article fits one sensor over runs of both activities.
TEST(Scenario, SkiAndBicyclePooledGiveTheCorrelationsOfTheArticle) {
  const Simulation ski = simulate(mems_of("ski.yaml"), 1), bicycle = simulate(mems_of("bicycle.yaml"), 1);
  const auto pooled = [](const TriadDraw& a, const TriadDraw& b) {
    TriadDraw both;
    both.run.mean = (a.run.mean + b.run.mean) / 2;
    both.run.rms = ((a.run.rms.cwiseAbs2() + b.run.rms.cwiseAbs2()) / 2).cwiseSqrt();
    return bias_scale_correlation(both);
  };
  for (std::size_t i = 0; i < ski.imus.size(); ++i) {
    expect_within(pooled(ski.imus[i].accel, bicycle.imus[i].accel), kAccelCorrelation, 0.05, "accel");
    expect_within(pooled(ski.imus[i].gyro, bicycle.imus[i].gyro), kGyroCorrelation, 0.15, "gyro");
  }
}

// The dynamics of the literature: rms of the rates about roll, pitch and yaw axes of the trunk, peak force, drop.
struct Dynamics {
  Vector3d rate_rms;
  double peak_force, drop;
};

Dynamics dynamics_of(const std::string& name) {
  const Scenario s = mems_of(name);
  const Truth trunk(World(s.origin), s.motion, s.seed, 0);
  Dynamics d{Vector3d::Zero(), 0, trunk.at(trunk.under_way().end).p_wb.z()};
  double count = 0;
  for (double t = trunk.under_way().start; t < trunk.under_way().end; t += 0.01, ++count) {
    const TruthState state = trunk.at(t);
    d.rate_rms += state.w_ib_b.cwiseAbs2();
    d.peak_force = std::max(d.peak_force, state.f_ib_b.norm() / kStandardGravity);
  }
  d.rate_rms = (d.rate_rms / count).cwiseSqrt() * kDegreesPerRadian;
  return d;
}

TEST(Scenario, GiantSlalomIsARace) {
  const Dynamics d = dynamics_of("giant_slalom.yaml");
  EXPECT_NEAR(d.rate_rms.x(), 125, 15);
  EXPECT_NEAR(d.rate_rms.y(), 21, 15);
  EXPECT_NEAR(d.rate_rms.z(), 18, 6);
  EXPECT_NEAR(d.peak_force, 3.1, 0.4);
  EXPECT_NEAR(d.drop, 437, 20);
}

TEST(Scenario, EasySkiIsEasy) {
  const Dynamics d = dynamics_of("easy_ski.yaml");
  EXPECT_NEAR(d.rate_rms.x(), 47, 6);
  EXPECT_NEAR(d.rate_rms.y(), 11, 6);
  EXPECT_NEAR(d.rate_rms.z(), 18, 5);
  EXPECT_NEAR(d.peak_force, 1.6, 0.3);
}

TEST(Scenario, BicycleGoesRoundAndIsSmooth) {
  const Dynamics d = dynamics_of("bicycle.yaml");
  EXPECT_LT(d.rate_rms.maxCoeff(), 8);
  EXPECT_LT(std::abs(d.drop), 0.1);
}

TEST(Scenario, SameSeedSameBytes) {
  Scenario s = shipped("giant_slalom.yaml");
  s.motion.rest_before = s.motion.rest_after = 5;
  s.motion.run = 15;
  const Simulation a = simulate(s, 8), b = simulate(s, 8), other = simulate(s, 9);
  for (std::size_t i = 0; i < a.imus.size(); ++i) {
    EXPECT_EQ(imu_csv(a.imus[i].recording), imu_csv(b.imus[i].recording));
    EXPECT_NE(imu_csv(a.imus[i].recording), imu_csv(other.imus[i].recording));
  }
  for (std::size_t i = 0; i < a.gnss.size(); ++i) EXPECT_EQ(gnss_csv(a.gnss[i]), gnss_csv(b.gnss[i]));
  EXPECT_EQ(attitude_csv(a.attitude[0]), attitude_csv(b.attitude[0]));
  EXPECT_EQ(truth_json(s, a, 8), truth_json(s, b, 8));

  // Leaving sensors at home changes no other.
  s.imus.erase(s.imus.begin());
  s.gnss.erase(s.gnss.begin());
  const Simulation fewer = simulate(s, 8);
  EXPECT_EQ(imu_csv(fewer.imus[0].recording), imu_csv(a.imus[1].recording));
  EXPECT_EQ(gnss_csv(fewer.gnss[0]), gnss_csv(a.gnss[1]));
}

TEST(Scenario, RaceReachesTheRangeOfTheMems) {
  Scenario s = mems_of("giant_slalom.yaml");
  s.imus.resize(1);
  const Simulation run = simulate(s, 1);
  EXPECT_GT(run.imus[0].accel.clipped, 10u);
  const double range = s.imus[0].sensor.accel.range;
  for (const Vector3d& f : run.imus[0].recording.accel) EXPECT_LE(f.cwiseAbs().maxCoeff(), range);
}

TEST(Scenario, FilesReadBackAsTheRecordings) {
  const std::filesystem::path folder = test::kSource / "data" / "ski_run";
  const Scenario s = shipped("ski_run.yaml");
  const Simulation run = simulate(s, s.seed);
  const ImuRecording imu = read_imu({(folder / "mt9a_1.csv").string()});
  ASSERT_EQ(imu.time.size(), run.imus[0].recording.time.size());
  for (std::size_t k = 0; k < imu.time.size(); k += 100) {
    EXPECT_NEAR(imu.time[k], run.imus[0].recording.time[k], 1e-6);
    EXPECT_LT((imu.gyro[k] - run.imus[0].recording.gyro[k]).norm(), 1e-7);
    EXPECT_LT((imu.accel[k] - run.imus[0].recording.accel[k]).norm(), 1e-6);
  }
  const GnssRecording gnss = read_gnss({(folder / "gnss.csv").string()});
  ASSERT_EQ(gnss.fixes.size(), run.gnss[0].fixes.size());
  const World world(s.origin);
  for (std::size_t k = 0; k < gnss.fixes.size(); k += 10) {
    const GeodeticFix &read = gnss.fixes[k], &made = run.gnss[0].fixes[k];
    EXPECT_LT((world.from_geodetic(read.position) - world.from_geodetic(made.position)).norm(), 1e-4);
    EXPECT_LT((read.velocity->value - made.velocity->value).norm(), 1e-4);
  }
  const AttitudeRecording attitude = read_attitude({(folder / "ln200_attitude.csv").string()});
  ASSERT_EQ(attitude.fixes.size(), run.attitude[0].fixes.size());
  EXPECT_LT((attitude.fixes[900].angles - run.attitude[0].fixes[900].angles).norm(), 1e-6);
}

TEST(Scenario, FilesHaveTheColumnsOfTheContract) {
  Scenario s = shipped("ski.yaml");
  s.motion.rest_before = s.motion.rest_after = 1;
  s.motion.run = 12;
  const Simulation run = simulate(s, 1);
  const auto header = [](const std::string& text) { return text.substr(0, text.find('\n')); };
  EXPECT_EQ(header(imu_csv(run.imus[0].recording)),
            "time_s,gyro_x_rad_s,gyro_y_rad_s,gyro_z_rad_s,accel_x_m_s2,accel_y_m_s2,accel_z_m_s2");
  EXPECT_EQ(header(gnss_csv(run.gnss[0])),
            "time_s,latitude_deg,longitude_deg,height_m,sigma_north_m,sigma_east_m,sigma_down_m,velocity_north_m_s,"
            "velocity_east_m_s,velocity_down_m_s,sigma_velocity_north_m_s,sigma_velocity_east_m_s,"
            "sigma_velocity_down_m_s");
  EXPECT_EQ(header(attitude_csv(run.attitude[0])),
            "time_s,roll_deg,pitch_deg,heading_deg,sigma_roll_deg,sigma_pitch_deg,sigma_heading_deg");
  EXPECT_EQ(header(truth_csv(run.bodies[0], run.imus[0].gps_time, 1)),
            "time_s,latitude_deg,longitude_deg,height_m,velocity_north_m_s,velocity_east_m_s,velocity_down_m_s,"
            "roll_deg,pitch_deg,heading_deg");
}

TEST(Scenario, ShippedRunIsWhatItsReadmeSays) {
  const auto content = [](const std::string& name) {
    std::ifstream in(test::kSource / "data" / "ski_run" / name, std::ios::binary);
    return std::string(std::istreambuf_iterator<char>(in), {});
  };
  const Scenario s = shipped("ski_run.yaml");
  const Simulation run = simulate(s, s.seed);
  EXPECT_TRUE(imu_csv(run.imus[0].recording) == content("mt9a_1.csv"));
  EXPECT_TRUE(gnss_csv(run.gnss[0]) == content("gnss.csv"));
  EXPECT_TRUE(gnss_csv(run.gnss[1]) == content("gnss_l1.csv"));
  EXPECT_TRUE(attitude_csv(run.attitude[0]) == content("ln200_attitude.csv"));
  EXPECT_TRUE(truth_csv(run.bodies[0], run.imus[0].gps_time, s.truth_every) == content("truth.csv"));
  EXPECT_EQ(truth_json(s, run, s.seed), content("truth.json"));
  EXPECT_LT((lever_arm(s.imus[0], s.gnss[0]) - Vector3d(-0.06, 0.03, -0.42)).norm(), 1e-5);
}

std::filesystem::path written(const std::string& name, const std::string& text) {
  const std::filesystem::path file = std::filesystem::path(testing::TempDir()) / name;
  std::ofstream(file) << text;
  return file;
}

TEST(Scenario, ReadsEveryKeyInItsUnit) {
  const std::string sensor = (test::kSource / "config/sensors/ln200.yaml").string();
  const Scenario s = read_scenario(written("every.yaml", R"(
origin: {latitude: 46 deg, longitude: 7 deg, height: 100 m}
start: 1000 s
seed: 5
motion: {rest_before: 3 s, run: 20 s, rest_after: 4 s, start_time: 4 s, stop_time: 3 s, speed_swing: 0.5 m/s,
         speed_period: 12 s, turn_variation: 0.2, crouch: 5 deg}
mounting: 0 -42 0 deg
imus:
  - name: one
    sensor: )" + sensor + R"(
    sampling: increments
    rate: 50 Hz
    clock: {offset: 1 s, drift: 100 ppm}
    errors:
      gyro: {bias: 0.1 0.2 0.3 deg/s, bias_spread: 0.01 0.02 0.03 deg/s, scale: 1000 2000 3000 ppm,
             scale_spread: 10 20 30 ppm, misalignment: 0.01, warm_up: 0.3 0.1 -0.2 deg/s, warm_up_time: 90 s,
             quantization: 1e-5 rad}
    magnetometer: {field: 21 1 42 uT, noise: 0.5 uT}
gnss:
  - {name: two, delay: 20 ms, velocity_noise: 0 0 0 m/s}
  - {name: three, delay: 20 ms, velocity_delay: 128 ms}
attitude: {name: four, delay: 15 ms}
)"));
  EXPECT_EQ(s.seed, 5u);
  EXPECT_NEAR(s.motion.crouch * kDegreesPerRadian, 5, 1e-12);
  const ImuSetup& imu = s.imus[0];
  EXPECT_NEAR(imu.clock_drift, 1e-4, 1e-18);
  EXPECT_NEAR(imu.gyro.bias->z() * kDegreesPerRadian, 0.3, 1e-12);
  EXPECT_NEAR(imu.gyro.scale->y(), 0.002, 1e-15);
  EXPECT_NEAR(imu.gyro.bias_spread.y() * kDegreesPerRadian, 0.02, 1e-12);
  EXPECT_NEAR(imu.gyro.scale_spread.z(), 3e-5, 1e-15);
  EXPECT_NEAR(imu.gyro.warm_up.z() * kDegreesPerRadian, -0.2, 1e-12);
  EXPECT_FALSE(imu.accel.bias);
  EXPECT_NEAR(imu.magnetic_field->z(), 42, 1e-9);
  EXPECT_NEAR(s.gnss[0].delay, 0.02, 1e-15);
  EXPECT_NEAR(s.gnss[0].delay_of_velocity(), 0.02, 1e-15);
  EXPECT_NEAR(s.gnss[1].delay_of_velocity(), 0.128, 1e-15);
  EXPECT_NEAR(s.attitude[0].delay, 0.015, 1e-15);

  const Simulation run = simulate(s, s.seed);
  const std::string truth = truth_json(s, run, s.seed);
  EXPECT_NE(truth.find("\"velocity_delay_s\": 0.128"), std::string::npos);
  EXPECT_NE(truth.find("\"delay_s\": 0.015"), std::string::npos);
  const SimulatedImu& rows = run.imus[0];
  ASSERT_EQ(rows.recording.magnetic.size(), rows.recording.time.size());
  EXPECT_NEAR(rows.recording.magnetic[10].norm(), Vector3d(21, 1, 42).norm(), 3);
  EXPECT_NE(rows.gyro.misalignment(0, 1), 0);
  const std::string csv = imu_csv(rows.recording);
  EXPECT_EQ(
      csv.substr(0, csv.find('\n')),
      "time_s,dtheta_x_rad,dtheta_y_rad,dtheta_z_rad,dvel_x_m_s,dvel_y_m_s,dvel_z_m_s,mag_x_uT,mag_y_uT,mag_z_uT");
}

TEST(Scenario, SpreadNeedsWhatItSpreadsAbout) {
  const auto refusal = [](const std::string& errors) {
    const std::filesystem::path file = written(
        "spread.yaml", "base: " + (kScenarios / "ski.yaml").string() + "\nimus:\n  - name: one\n    sensor: " +
                           (kScenarios / "../sensors/ln200.yaml").string() + "\n    errors: {gyro: " + errors + "}\n");
    return test::message_of<ConfigError>([&] { read_scenario(file); });
  };
  EXPECT_TRUE(
      test::contains(refusal("{bias_spread: 1 1 1 deg/s}"), "spread.yaml:5: bias_spread: spreads about `bias`"));
  EXPECT_TRUE(test::contains(refusal("{bias: 0 0 0 deg/s, scale_spread: 1 1 1 ppm}"), "give `scale` too"));
  EXPECT_TRUE(test::contains(refusal("{scale: 0 0 0 ppm, scale_spread: 1 -1 1 ppm}"), "must not be negative"));
}

TEST(Scenario, TruthHasTheMeansOfEveryPhase) {
  Scenario s = mems_of("ski.yaml");
  s.motion.run = 12;
  s.motion.rest_after = 0;
  s.imus.resize(1);
  const Simulation run = simulate(s, 1);
  const YAML::Node accel = YAML::Load(truth_json(s, run, 1))["imus"]["mt9a_1"]["accel"];
  const auto expect = [&](const char* member, const Vector3d& value) {
    for (int i = 0; i < 3; ++i) EXPECT_NEAR(accel[member][i].as<double>(), value(i), 1e-8 * value.norm()) << member;
  };
  expect("drift_before_m_s2", run.imus[0].accel.before.drift);
  expect("mean_before_m_s2", run.imus[0].accel.before.mean);
  expect("drift_run_m_s2", run.imus[0].accel.run.drift);
  expect("run_mean_m_s2", run.imus[0].accel.run.mean);
  expect("run_rms_m_s2", run.imus[0].accel.run.rms);
  EXPECT_TRUE(accel["drift_after_m_s2"].IsNull());
  EXPECT_TRUE(accel["mean_after_m_s2"].IsNull());
}

TEST(Scenario, ImpossibleMotionIsRefusedWithItsLine) {
  const std::filesystem::path file = written(
      "impossible.yaml", "origin: {latitude: 46 deg, longitude: 7 deg, height: 0 m}\nmotion:\n  run: 3 s\nimus: []\n");
  try {
    read_scenario(file);
    FAIL() << "accepted";
  } catch (const ConfigError& e) {
    EXPECT_NE(std::string(e.what()).find("impossible.yaml:"), std::string::npos) << e.what();
    EXPECT_NE(std::string(e.what()).find("run must be longer"), std::string::npos) << e.what();
  }
}

TEST(Scenario, AHeightInKilometresIsRefusedWithItsLine) {
  const std::filesystem::path file = written(
      "deep.yaml", "origin:\n  latitude: 46 deg\n  longitude: 7 deg\n  height: -7000 km\nmotion: {}\nimus: []\n");
  const std::string message = test::message_of<ConfigError>([&] { read_scenario(file); });
  EXPECT_TRUE(test::contains(message, "deep.yaml:4: height: must lie between -12 and 1000 km")) << message;
}

}  // namespace
}  // namespace piste
