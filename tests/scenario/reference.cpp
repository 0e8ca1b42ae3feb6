// The reference solution and its use, through the programs: an LN200 with GPS L1/L2, smoothed, whose attitude.csv an
// MT-9A on the same plate is replayed with. Prints what README quotes.

#include <gtest/gtest.h>
#include <yaml-cpp/yaml.h>

#include "piste/math/statistics.h"
#include "support/navigation.h"
#include "support/places.h"
#include "support/program.h"

namespace piste::test {
namespace {

const std::filesystem::path kSource = source_folder();
const std::array kAngles{"roll", "pitch", "heading"};

// Errors of an attitude log against the truth at its epochs.
struct Errors {
  Vector3d rmse = Vector3d::Zero();  ///< deg
  double largest = 0;                ///< in its own sigmas, of any angle
  double nees = 0;                   ///< mean square in sigmas, of all angles
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
      const double in_sigmas = error / attitude["sigma_" + name][i];
      e.rmse(static_cast<Eigen::Index>(k)) += error * error;
      e.largest = std::max(e.largest, std::abs(in_sigmas));
      e.nees += in_sigmas * in_sigmas / 3;
    }
  }
  e.rmse = (e.rmse / static_cast<double>(e.epochs)).cwiseSqrt();
  e.nees /= static_cast<double>(e.epochs);
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
  double boresight;  ///< deg: how near the MT-9A can tell it there
};

class Reference : public testing::TestWithParam<Course> {};

TEST_P(Reference, CarriesTheMt9a) {
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
      "%s: reference, rmse under way %.4f %.4f %.4f deg, at worst %.1f sigma; whole log %.4f %.4f %.4f deg, %.1f "
      "sigma\n",
      GetParam().name, under_way.rmse.x(), under_way.rmse.y(), under_way.rmse.z(), under_way.largest, whole.rmse.x(),
      whole.rmse.y(), whole.rmse.z(), whole.largest);
  EXPECT_EQ(under_way.epochs, 901U);
  EXPECT_LT(under_way.rmse.x(), 0.03);
  EXPECT_LT(under_way.rmse.y(), 0.03);
  EXPECT_LT(under_way.rmse.z(), 0.05);
  EXPECT_LT(whole.largest, 4);
  // Errors last as long as the run: three angles are little more than three draws.
  EXPECT_LT(under_way.nees, chi_squared_quantile(0.999, 3) / 3);
  EXPECT_GT(under_way.nees, chi_squared_quantile(0.001, 3) / 3);

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
    EXPECT_LT(std::abs(off), GetParam().boresight) << k;
    EXPECT_LT(sigma, GetParam().boresight) << k;
  }
}

// Gentle turns tell the tilt of an MT-9A from its accelerometers' drift to 0.03 deg and no better.
INSTANTIATE_TEST_SUITE_P(Scenarios, Reference, testing::Values(Course{"ski", 0.06}, Course{"giant_slalom", 0.02}),
                         [](const auto& given) { return std::string(given.param.name); });

}  // namespace
}  // namespace piste::test
