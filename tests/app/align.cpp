// `align` and `compare` as their user sees them: what they write, say and return.

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <yaml-cpp/yaml.h>

#include <array>
#include <cmath>

#include "support/navigation.h"
#include "support/places.h"
#include "support/program.h"

namespace piste::test {
namespace {

namespace fs = std::filesystem;

std::string imu_entry(const std::string& file, const std::string& sensor = "xsens_mt9a") {
  return fmt::format("{{file: run/{}, sensor: {}/config/sensors/{}.yaml}}", file, source_folder(), sensor);
}

std::string usual_config() {
  return fmt::format("imu: {}\nreference: {}\n", imu_entry("mt9a_1.csv"), imu_entry("ln200.csv", "ln200"));
}

double joint_sigma(const YAML::Node& found, const char* axis) {
  return found["axes"][axis]["run"]["joint"]["reverse"]["scale"]["standard_error"].as<double>();
}

/// A folder with a short ski run in `run`: three MT-9A and an LN200.
class Align : public testing::Test {
 protected:
  void SetUp() override {
    folder_.write("short.yaml",
                  fmt::format("base: {}/config/scenarios/ski.yaml\n"
                              "motion: {{rest_before: 5 s, run: 40 s, rest_after: 5 s, net_turn: 160 deg}}\n"
                              "gnss: []\nattitude: []\n",
                              source_folder()));
    const Said said = run_program(program("simulate"), {folder_ / "short.yaml", "--output", "run", "--quiet"}, folder_);
    ASSERT_EQ(said.code, 0) << said.err;
  }

  Said align(const std::string& config, const std::string& name = program("align")) const {
    folder_.write("align.yaml", config);
    return run_program(name, {folder_ / "align.yaml", "--output", "out"}, folder_);
  }

  TemporaryFolder folder_;
};

Vector3d vector_of(const YAML::Node& node) {
  return {node[0].as<double>(), node[1].as<double>(), node[2].as<double>()};
}

void expect_true(const YAML::Node& found, const YAML::Node& truth) {
  EXPECT_NEAR(found["clock_offset_s"].as<double>(), truth["clock_offset_s"].as<double>(), 0.2e-3);
  EXPECT_NEAR(found["clock_drift_ppm"].as<double>(), truth["clock_drift_ppm"].as<double>(), 3);
  const Vector3d boresight = vector_of(found["boresight_deg"]) - vector_of(truth["boresight_deg"]),
                 arm = vector_of(found["lever_arm_m"]) - vector_of(truth["position_m"]);
  EXPECT_LT(boresight.cwiseAbs().maxCoeff(), 0.05);
  EXPECT_LT(arm.cwiseAbs().maxCoeff(), 2e-3);
  for (int i = 0; i < 3; ++i) {
    const double sigma_boresight = found["sigma_boresight_deg"][i].as<double>(),
                 sigma_arm = found["sigma_lever_arm_m"][i].as<double>();
    EXPECT_LT(std::abs(boresight(i)), 4 * sigma_boresight);
    EXPECT_LT(std::abs(arm(i)), 4 * sigma_arm);
    EXPECT_LT(sigma_boresight, 0.02);
    EXPECT_LT(sigma_arm, 0.6e-3);
  }
  EXPECT_EQ(found["undetermined"].size(), 0U);
}

TEST_F(Align, WritesWhatItFound) {
  const Said said = align(usual_config());
  ASSERT_EQ(said.code, 0) << said.err;
  EXPECT_EQ(said.err, "");
  EXPECT_TRUE(contains(said.out, "written to out"));
  const YAML::Node truth = YAML::LoadFile(folder_ / "run/truth.json")["imus"]["mt9a_1"];
  expect_true(YAML::LoadFile(folder_ / "out/alignment.json"), truth);

  // Both signals agree once aligned, but for the body IMU's noise, biases and scales.
  const Table table = read_table(folder_ / "out/aligned.csv");
  const auto &body = table["gyro_z_deg_s"], &reference = table["reference_gyro_z_deg_s"];
  ASSERT_GT(body.size(), 4000U);
  double mean = 0, square = 0;
  for (std::size_t i = 0; i < body.size(); ++i) mean += (body[i] - reference[i]) / static_cast<double>(body.size());
  for (std::size_t i = 0; i < body.size(); ++i) {
    square += std::pow(body[i] - reference[i] - mean, 2) / static_cast<double>(body.size());
  }
  EXPECT_LT(std::sqrt(square), 1.0);
  EXPECT_NEAR(mean, truth["gyro"]["bias_deg_s"][2].as<double>(), 0.2);
  for (const auto& entry : fs::recursive_directory_iterator(folder_.path() / "out")) {
    EXPECT_FALSE(entry.path().filename().string().ends_with(".partial")) << entry.path();
  }
}

TEST_F(Align, SeveralImusOnOnePlate) {
  const Said said = align(fmt::format("imu:\n  - {}\n  - {}\nreference: {}\n", imu_entry("mt9a_1.csv"),
                                      imu_entry("mt9a_3.csv"), imu_entry("ln200.csv", "ln200")));
  ASSERT_EQ(said.code, 0) << said.err;
  const YAML::Node truth = YAML::LoadFile(folder_ / "run/truth.json")["imus"];
  for (const char* name : {"mt9a_1", "mt9a_3"}) {
    expect_true(YAML::LoadFile(folder_ / fmt::format("out/{}/alignment.json", name)), truth[name]);
  }
}

TEST_F(Align, SameBytesAgain) {
  ASSERT_EQ(align(usual_config()).code, 0);
  const std::string once = read_text(folder_.path() / "out/alignment.json");
  ASSERT_EQ(align(usual_config()).code, 0);
  EXPECT_EQ(once, read_text(folder_.path() / "out/alignment.json"));
}

TEST_F(Align, CompareAddsTheErrorsOfTheSensor) {
  const Said said = align(usual_config(), program("compare"));
  ASSERT_EQ(said.code, 0) << said.err;
  const YAML::Node truth = YAML::LoadFile(folder_ / "run/truth.json"), imu = truth["imus"]["mt9a_1"],
                   found = YAML::LoadFile(folder_ / "out/findings.json");
  expect_true(found, imu);
  EXPECT_TRUE(fs::exists(folder_.path() / "out/alignment.json"));
  EXPECT_TRUE(fs::exists(folder_.path() / "out/aligned.csv"));
  // Found from the signals alone: rest, run, rest.
  for (int i = 0; i < 2; ++i) EXPECT_NEAR(found["phases"]["run"][i].as<double>(), truth["run_s"][i].as<double>(), 2);
  const std::array axes{"wx", "wy", "wz"};
  for (int i = 0; i < 3; ++i) {
    const YAML::Node joint = found["axes"][axes[static_cast<std::size_t>(i)]]["run"]["joint"]["reverse"];
    const double bias = imu["gyro"]["bias_deg_s"][i].as<double>() + imu["gyro"]["drift_mean_deg_s"][i].as<double>();
    EXPECT_NEAR(joint["bias"]["value"].as<double>(), bias, 0.1) << i;
    EXPECT_NEAR(joint["scale"]["value"].as<double>(), imu["gyro"]["scale_ppm"][i].as<double>(), 12000) << i;
  }
  EXPECT_LT(joint_sigma(found, "wx"), 5000);
}

TEST_F(Align, ComparePhasesMayBeStated) {
  const std::string phases = "phases: {run: [302410 s, 302440 s], after: [302446 s, 302449 s]}\n";
  const Said said = align(usual_config() + phases, program("compare"));
  ASSERT_EQ(said.code, 0) << said.err;
  const YAML::Node found = YAML::LoadFile(folder_ / "out/findings.json");
  EXPECT_TRUE(found["phases"]["before"].IsNull());
  EXPECT_EQ(found["phases"]["run"][1].as<double>(), 302440);

  const Said outside = align(usual_config() + "phases: {before: [0 s, 60 s]}\n", program("compare"));
  EXPECT_EQ(outside.code, 1);
  EXPECT_TRUE(contains(outside.err, "mt9a_1.csv: the rest before from 0.000 to 60.000 s")) << outside.err;
  EXPECT_TRUE(contains(outside.err, "both have samples from 3024")) << outside.err;
  EXPECT_TRUE(found["axes"]["fx"]["rest"]["before"].IsNull());
  EXPECT_FALSE(found["axes"]["fx"]["rest"]["after"].IsNull());
}

struct Wrong {
  std::string name, config;
  int code;
  std::vector<std::string> says;
};

class AlignRefuses : public Align, public testing::WithParamInterface<const char*> {};

std::vector<Wrong> wrong() {
  const std::string imu = "imu: " + imu_entry("mt9a_1.csv") + "\n",
                    reference = "reference: " + imu_entry("ln200.csv", "ln200") + "\n";
  return {
      {"NoReference", imu, 2, {"align.yaml", "reference"}},
      {"NoImu", reference, 2, {"align.yaml", "imu"}},
      {"MisspelledKey", imu + reference + "lowpass: 12 Hz\n", 2, {"align.yaml:3: ", "lowpass", "low_pass"}},
      {"NoUnit", imu + reference + "low_pass: 12\n", 2, {"align.yaml:3: ", "low_pass", "unit"}},
      {"BeyondTheRate", imu + reference + "low_pass: 60 Hz\n", 2, {"mt9a_1.csv", "low_pass: 60 Hz", "100 Hz"}},
      {"SameFileTwice", imu + "reference: " + imu_entry("mt9a_1.csv") + "\n", 2, {"align.yaml:2: ", "count twice"}},
      {"SameNameTwice",
       fmt::format("imu: [{0}, {0}]\n", imu_entry("mt9a_1.csv")) + reference,
       2,
       {"align.yaml:1: ", "name"}},
      {"NoSuchFile", "imu: " + imu_entry("mt9a_9.csv") + "\n" + reference, 2, {"align.yaml:1: ", "mt9a_9.csv"}},
      {"LeftHanded", "imu: " + imu_entry("mirrored.csv") + "\n" + reference, 1, {"mirrored.csv: ", "left-handed"}},
      {"Radians", "imu: " + imu_entry("radians.csv") + "\n" + reference, 1, {"radians.csv: ", "rad/s or deg/s?"}},
      {"CutInALine", "imu: " + imu_entry("cut.csv") + "\n" + reference, 1, {"cut.csv:"}},
      {"PhasesUnknown", imu + reference + "phases: none\n", 2, {"align.yaml:3: ", "phases", "auto"}},
      {"PhasesOverlap",
       imu + reference + "phases: {before: [1 s, 3 s], run: [2 s, 4 s]}\n",
       2,
       {"align.yaml:3: ", "run", "before the phase"}},
      {"TooShort", imu + reference + "span: {start: 302414 s, end: 302416 s}\n", 1, {"mt9a_1.csv: ", "too short"}},
  };
}

TEST_P(AlignRefuses, WithItsReason) {
  const std::string all = read_text(folder_ / "run/mt9a_1.csv");
  folder_.write("run/cut.csv", all.substr(0, all.size() / 2));
  std::string radians = all;
  for (std::size_t at; (at = radians.find("_rad_s")) != std::string::npos;) radians.replace(at, 6, "_deg_s");
  folder_.write("run/radians.csv", radians);
  // A header that says y where the sensor's axis points the other way.
  std::string mirrored;
  std::istringstream lines(all);
  for (std::string line; std::getline(lines, line); mirrored += line + "\n") {
    for (const int column : {2, 5}) {
      std::size_t at = 0;
      for (int i = 0; i < column; ++i) at = line.find(',', at) + 1;
      if (line.starts_with("time")) continue;
      if (line[at] == '-') {
        line.erase(at, 1);
      } else {
        line.insert(at, "-");
      }
    }
  }
  folder_.write("run/mirrored.csv", mirrored);
  const std::vector<Wrong> all_wrong = wrong();
  const auto found =
      std::find_if(all_wrong.begin(), all_wrong.end(), [](const Wrong& w) { return w.name == GetParam(); });
  ASSERT_NE(found, all_wrong.end());
  const Wrong& w = *found;
  const Said said = align(w.config);
  EXPECT_EQ(said.code, w.code) << said.err;
  for (const std::string& part : w.says) EXPECT_TRUE(contains(said.err, part));
  EXPECT_FALSE(fs::exists(folder_.path() / "out"));
}

INSTANTIATE_TEST_SUITE_P(Cases, AlignRefuses,
                         testing::Values("NoReference", "NoImu", "MisspelledKey", "NoUnit", "BeyondTheRate",
                                         "SameFileTwice", "SameNameTwice", "NoSuchFile", "LeftHanded", "Radians",
                                         "CutInALine", "PhasesUnknown", "PhasesOverlap", "TooShort"),
                         [](const auto& name) { return std::string(name.param); });

}  // namespace
}  // namespace piste::test
