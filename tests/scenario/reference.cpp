// The reference solution and its use: an LN200 with GPS L1/L2, smoothed, whose sigmas are true over many seeds; and
// through the programs one whose attitude.csv an MT-9A on the same plate is replayed with. Prints what README quotes.

#include <gtest/gtest.h>
#include <yaml-cpp/yaml.h>

#include <ostream>
#include <string_view>
#include <thread>

#include "piste/trial/ensemble.h"
#include "support/navigation.h"
#include "support/places.h"
#include "support/program.h"
#include "support/thorough.h"

namespace piste::test {
namespace {

const std::array kAngles{"roll", "pitch", "heading"};

// Errors of an attitude log against the truth at its epochs.
struct Errors {
  Vector3d rmse = Vector3d::Zero();     ///< deg
  Vector3d claimed = Vector3d::Zero();  ///< RMS of the sigmas, deg
  double largest = 0;                   ///< in its own sigmas, of any angle
  std::size_t epochs = 0;
};

Errors errors_of(const Table& attitude, const Table& truth, const Interval& during) {
  Errors e;
  for (std::size_t i = 0; i < attitude.rows; ++i) {
    const double t = attitude["time_s"][i];
    if (!during.contains(t)) continue;
    ++e.epochs;
    for (std::size_t k = 0; k < kAngles.size(); ++k) {
      const std::string name = fmt::format("{}_deg", kAngles[k]);
      const double error = std::remainder(attitude[name][i] - at(truth, name, t), 360.0);
      const double sigma = attitude["sigma_" + name][i];
      e.rmse(static_cast<Eigen::Index>(k)) += error * error;
      e.claimed(static_cast<Eigen::Index>(k)) += sigma * sigma;
      e.largest = std::max(e.largest, std::abs(error) / sigma);
    }
  }
  e.rmse = (e.rmse / static_cast<double>(e.epochs)).cwiseSqrt();
  e.claimed = (e.claimed / static_cast<double>(e.epochs)).cwiseSqrt();
  return e;
}

// What a replay needs to know of the receiver.
std::string gnss_of(const YAML::Node& imu) {
  const YAML::Node l = imu["lever_arm_m"]["gnss_l1l2"];
  return fmt::format("gnss: {{file: run/gnss_l1l2.csv, lever_arm: {} {} {} m}}\n", l[0].as<std::string>(),
                     l[1].as<std::string>(), l[2].as<std::string>());
}

struct Course {
  const char* name;
  Vector3d claimed;  ///< deg: how sure the reference may be of roll, pitch and heading under way, at least
  double boresight;  ///< deg: how sure the MT-9A may be of it there, at least
};

void PrintTo(const Course& course, std::ostream* out) { *out << course.name; }

class Reference : public testing::TestWithParam<Course> {};

TEST_P(Reference, CarriesTheMt9a) {
  if (!thorough() && std::string_view(GetParam().name) != "ski") GTEST_SKIP() << "with PISTE_THOROUGH=1";
  const TemporaryFolder folder;
  const Said simulated = run_program(
      program("simulate"),
      {fmt::format("{}/config/scenarios/{}.yaml", kSource.string(), GetParam().name), "--output", "run", "--quiet"},
      folder);
  ASSERT_EQ(simulated.code, 0) << simulated.err;
  const YAML::Node truth = YAML::LoadFile(folder / "run/truth.json");
  const Interval run{truth["run_s"][0].as<double>(), truth["run_s"][1].as<double>()};
  const std::string sensors = (kSource / "config/sensors").string();
  const std::string rest_of_it =
      "initial: {heading: auto}\n"
      "estimate: [gyro_bias, accel_bias, gyro_drift, accel_drift, gyro_scale, accel_scale";

  folder.write("ln200.yaml", fmt::format("imu: {{file: run/ln200.csv, sensor: {}/ln200.yaml}}\n{}{}]\n", sensors,
                                         gnss_of(truth["imus"]["ln200"]), rest_of_it));
  const Said reference = run_program(program("replay"), {"ln200.yaml", "--output", "reference", "--quiet"}, folder);
  ASSERT_EQ(reference.code, 0) << reference.err;
  const Table attitude = read_table(folder / "reference/attitude.csv"),
              true_attitude = read_table(folder / "run/truth_ln200.csv");
  const Errors whole = errors_of(attitude, true_attitude, {attitude["time_s"].front(), attitude["time_s"].back()});
  const Errors under_way = errors_of(attitude, true_attitude, run);
  std::printf(
      "%s: reference, rmse under way %.4f %.4f %.4f deg, claimed %.4f %.4f %.4f deg, at worst %.1f sigma; whole log "
      "%.4f %.4f %.4f deg, %.1f sigma\n",
      GetParam().name, under_way.rmse.x(), under_way.rmse.y(), under_way.rmse.z(), under_way.claimed.x(),
      under_way.claimed.y(), under_way.claimed.z(), under_way.largest, whole.rmse.x(), whole.rmse.y(), whole.rmse.z(),
      whole.largest);
  EXPECT_EQ(under_way.epochs, 901U);
  EXPECT_LT(whole.largest, 4);
  for (int k = 0; k < 3; ++k) EXPECT_LT(under_way.claimed(k), GetParam().claimed(k)) << k;

  const YAML::Node error = YAML::LoadFile(folder / "reference/summary.json")["attitude_error"];
  const auto tau = error["correlation_time_s"].as<double>();
  EXPECT_GT(tau, 50);  // biases stay, and the heading at rest wanders within minutes
  EXPECT_LE(tau, attitude["time_s"].back() - attitude["time_s"].front() + 1);

  const YAML::Node imu = truth["imus"]["mt9a_1"];
  folder.write(
      "mt9a.yaml",
      fmt::format("imu: {{file: run/mt9a_1.csv, sensor: {}/xsens_mt9a.yaml, clock: {{offset: {} s, drift: {} "
                  "ppm}}}}\n{}attitude: {{file: reference/attitude.csv, correlation_time: {} s}}\n{}, boresight]\n",
                  sensors, imu["clock_offset_s"].as<std::string>(), imu["clock_drift_ppm"].as<std::string>(),
                  gnss_of(imu), tau, rest_of_it));
  const Said said = run_program(program("replay"), {"mt9a.yaml", "--output", "result", "--quiet"}, folder);
  ASSERT_EQ(said.code, 0) << said.err;
  const YAML::Node summary = YAML::LoadFile(folder / "result/summary.json");
  EXPECT_LT(summary["attitude"]["rejected"].as<int>(), 45);  // a hundredth
  const YAML::Node boresight = summary["estimates"]["boresight"];
  for (int k = 0; k < 3; ++k) {
    const double off = boresight["value"][k].as<double>() - imu["boresight_deg"][k].as<double>();
    const auto sigma = boresight["sigma"][k].as<double>();
    std::printf("%s: boresight, %s off by %.4f deg, sigma %.4f\n", GetParam().name,
                kAngles[static_cast<std::size_t>(k)], off, sigma);
    EXPECT_LT(std::abs(off), 4 * sigma) << k;
    EXPECT_LT(sigma, GetParam().boresight) << k;
  }
}

// The errors of an attitude last as long as the run, so that seeds count and epochs do not: the mean NEES over them is
// held to the band of as many draws of three angles. Of seeds 1 to 60, shortened to a minute, ski has TBD and giant
// slalom TBD, where the band is TBD.
TEST_P(Reference, HasTrueSigmas) {
  const TemporaryFolder folder;
  const Scenario scenario = read_scenario(folder.write(
      "reference.yaml", fmt::format("base: {}/config/scenarios/{}.yaml\nseed: 1\n"
                                    "motion: {{rest_before: 20 s, run: 35 s, rest_after: 5 s, net_turn: 90 deg}}\n"
                                    "montecarlo: {{imu: ln200, gnss: gnss_l1l2}}\n",
                                    kSource.string(), GetParam().name)));
  Ensemble ensemble(scenario);
  ensemble.run(static_cast<std::size_t>(seeds(8, 60)), std::max(1U, std::thread::hardware_concurrency()));
  const ConsistencyReport report = ensemble.sums().report(0.999);
  EXPECT_TRUE(report.failures.empty());
  const auto group =
      static_cast<std::size_t>(std::ranges::find(report.groups, "attitude", &StateGroup::name) - report.groups.begin());
  ASSERT_LT(group, report.groups.size());
  const Band& band = report.bands[group];
  for (const EstimatorConsistency* estimator : {&report.filter, &report.smoother}) {
    const double nees = estimator->groups[static_cast<std::size_t>(Phase::kUnderWay)].at(group).nees;
    std::printf("%s, %d runs: NEES of the attitude %.3f, band %.3f to %.3f\n", GetParam().name, report.runs, nees,
                band.low, band.high);
    EXPECT_TRUE(band.contains(nees)) << nees << " outside " << band.low << " to " << band.high;
  }
}

// Gentle turns tell the tilt of an MT-9A from its accelerometers' drift to 0.03 deg and no better.
INSTANTIATE_TEST_SUITE_P(Scenarios, Reference,
                         testing::Values(Course{"ski", {0.008, 0.006, 0.015}, 0.035},
                                         Course{"giant_slalom", {0.008, 0.006, 0.015}, 0.009}),
                         [](const auto& given) { return std::string(given.param.name); });

}  // namespace
}  // namespace piste::test
