// `descents` as its user sees it: two runs of one course, simulated, whose true crossing times are known.

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <yaml-cpp/yaml.h>

#include <cmath>

#include "support/navigation.h"
#include "support/places.h"
#include "support/program.h"

namespace piste::test {
namespace {

class DescentsApp : public testing::Test {
 protected:
  // Two IMUs and two receivers on one way, as of two skiers who go alike: nothing is truly gained.
  void SetUp() override {
    std::string scenario = fmt::format(
        "base: {0}/config/scenarios/ski_run.yaml\ntruth_every: 1\nattitude: []\n"
        "motion: {{rest_before: 20 s, run: 40 s, rest_after: 5 s, net_turn: 160 deg}}\nimus:\n",
        source_folder());
    std::string gnss = "gnss:\n";
    for (const char* n : {"1", "2"}) {
      scenario += fmt::format(
          "  - {{name: imu_{}, sensor: {}/config/sensors/xsens_mt9a.yaml, boresight: 1.9 -2.4 2.1 deg, position: 0.06 "
          "0.05 "
          "-0.03 m, rate: 100 Hz}}\n",
          n, source_folder());
      gnss += fmt::format(
          "  - {{name: gnss_{}, lever_arm: 0.01601 0.09233 -0.45092 m, rate: 10 Hz, position_noise: 0.01 0.01 0.02 m, "
          "velocity_noise: 0.025 0.025 0.04 m/s}}\n",
          n);
      folder_.write(fmt::format("run_{}.yaml", n),
                    fmt::format("imu: {{file: logs/imu_{0}.csv, sensor: {1}/config/sensors/xsens_mt9a.yaml}}\n"
                                "gnss: {{file: logs/gnss_{0}.csv, lever_arm: -0.06 0.03 -0.42 m}}\n"
                                "estimate: [gyro_bias, accel_bias, gyro_drift, accel_drift, gyro_scale, accel_scale]\n"
                                "output: {{at: {{antenna: -0.06 0.03 -0.42 m}}}}\n",
                                n, source_folder()));
    }
    folder_.write("course.yaml", scenario + gnss);
    const Said said = run_program(program("simulate"), {"course.yaml", "--output", "logs", "--quiet"}, folder_);
    ASSERT_EQ(said.code, 0) << said.err;
    truth_ = read_table(folder_ / "logs/truth.csv");
    std::string gates = "name,latitude_deg,longitude_deg,heading_deg\n";
    for (const double part : {0.4, 0.5, 0.6, 0.75}) {
      const auto row = static_cast<std::size_t>(part * static_cast<double>(truth_.rows));
      rows_.push_back(row);
      const double course = std::atan2(truth_["velocity_east_m_s"][row], truth_["velocity_north_m_s"][row]) / kDegree;
      gates += fmt::format("gate {},{:.10f},{:.10f},{}\n", rows_.size(), truth_["latitude_deg"][row],
                           truth_["longitude_deg"][row], rows_.size() == 3 ? "" : fmt::format("{:.3f}", course));
    }
    folder_.write("gates.csv", gates);
  }
  Said descents(std::vector<std::string> words) const {
    words.insert(words.end(), {"--output", "out"});
    return run_program(program("descents"), words, folder_);
  }

  TemporaryFolder folder_;
  Table truth_;
  std::vector<std::size_t> rows_;
};

TEST_F(DescentsApp, TimesGatesAndSections) {
  const Said said = descents({"anna=run_1.yaml", "run_2.yaml", "--gates", "gates.csv", "--common", "0.01 m"});
  ASSERT_EQ(said.code, 0) << said.err;
  const YAML::Node found = YAML::LoadFile(folder_ / "out/descents.json");
  EXPECT_EQ(found["runs"][0].as<std::string>(), "anna");
  EXPECT_EQ(found["runs"][1].as<std::string>(), "run_2");
  EXPECT_EQ(found["line"].as<std::string>(), "anna");
  ASSERT_EQ(found["gates"].size(), 4u);
  EXPECT_EQ(found["gates"][0]["distance_m"].as<double>(), 0);
  for (std::size_t i = 0; i < 4; ++i) {
    for (const char* name : {"anna", "run_2"}) {
      const YAML::Node at = found["gates"][i]["runs"][name];
      const double sigma = at["sigma_time_s"].as<double>();
      EXPECT_GT(sigma, 2e-4);
      EXPECT_LT(sigma, 3e-3);
      EXPECT_LT(std::abs(at["time_s"].as<double>() - truth_["time_s"][rows_[i]]), 5 * sigma) << name << " at " << i;
      EXPECT_LT(std::abs(at["offset_m"].as<double>()), 0.1);
    }
    const YAML::Node at = found["gates"][i]["runs"]["run_2"];
    const double sigma = at["sigma_gained_s"].as<double>();
    EXPECT_LE(std::abs(at["gained_s"].as<double>()), 5 * sigma);
    if (i > 0) {
      EXPECT_GT(sigma, 1e-4);
      EXPECT_LT(sigma, 2e-3);
    }
  }
  const Table sections = read_table(folder_ / "out/sections.csv"), gained = read_table(folder_ / "out/gained.csv");
  EXPECT_EQ(sections.header.substr(0, 14), "from,to,length");
  ASSERT_EQ(sections.rows, 3u);
  double last = 0;
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_NEAR(sections["duration_s_anna"][i] - sections["duration_s_run_2"][i], sections["gained_s_run_2"][i], 2e-6);
    EXPECT_LE(std::abs(sections["gained_s_run_2"][i]), 5 * sections["sigma_s_run_2"][i]);
    last += sections["length_m"][i];
  }
  EXPECT_EQ(gained["distance_m"].front(), 0);
  EXPECT_NEAR(gained["distance_m"].back(), last, 1e-3);
  EXPECT_EQ(gained["gained_s_run_2"].front(), 0);
  for (std::size_t i = 1; i < gained.rows; ++i) {
    EXPECT_LE(gained["distance_m"][i] - gained["distance_m"][i - 1], 1.0001);
    EXPECT_LE(std::abs(gained["gained_s_run_2"][i]), 5.5 * gained["sigma_s_run_2"][i] + 2e-6) << i;
  }
  // A short way is surer than a long one: errors of neighbouring epochs are alike.
  EXPECT_LT(gained["sigma_s_run_2"][3], 0.8 * gained["sigma_s_run_2"].back());
  EXPECT_NE(read_text(folder_ / "out/descents.html").find("Where time was lost"), std::string::npos);
}

TEST_F(DescentsApp, FoldersHaveNoSigmasOfGainedTimes) {
  for (const char* run : {"run_1", "run_2"}) {
    ASSERT_EQ(run_program(program("replay"),
                          {std::string(run) + ".yaml", "--output", std::string("out_") + run, "--quiet"}, folder_)
                  .code,
              0);
  }
  const Said said =
      descents({"a=out_run_1", "b=out_run_2", "--gates", "gates.csv", "--at", "antenna", "--line", "mean"});
  ASSERT_EQ(said.code, 0) << said.err;
  EXPECT_NE(said.err.find("no covariance between two crossings"), std::string::npos);
  const YAML::Node found = YAML::LoadFile(folder_ / "out/descents.json");
  EXPECT_TRUE(found["gates"][1]["runs"]["b"]["sigma_gained_s"].IsNull());
  EXPECT_TRUE(found["gates"][1]["runs"]["b"]["sigma_time_s"].IsScalar());
  EXPECT_EQ(found["line"].as<std::string>(), "mean");
  // Without a file the gates are the apexes of turns.
  ASSERT_EQ(descents({"a=out_run_1", "b=out_run_2"}).code, 0);
  const YAML::Node turns = YAML::LoadFile(folder_ / "out/descents.json");
  EXPECT_EQ(turns["gates"][0]["name"].as<std::string>(), "turn_1");
  EXPECT_GT(turns["gates"].size(), 5u);

  EXPECT_EQ(descents({"out_run_1"}).code, 2);
  EXPECT_EQ(descents({"out_run_1", "out_run_1"}).code, 2);
  EXPECT_EQ(descents({"out_run_1", "out_run_2", "--line", "nobody"}).code, 2);
  EXPECT_EQ(descents({"out_run_1", "out_run_2", "--common", "1 kg"}).code, 2);
  folder_.write("far.csv", "name,latitude_deg,longitude_deg,heading_deg\nnear,46,7,0\nfar,47,8,90\n");
  const Said far = descents({"out_run_1", "out_run_2", "--gates", "far.csv"});
  EXPECT_EQ(far.code, 1);
  EXPECT_NE(far.err.find("does not cross the gate"), std::string::npos) << far.err;
}

// Two seeds of a scenario with a course: its gates are those that `descents` takes, and truth.json says what is gained.
TEST(DescentsOfACourse, GainWhatTheTruthSays) {
  const TemporaryFolder folder;
  folder.write("course.yaml", fmt::format("base: {}/config/scenarios/course.yaml\ncourse: {{gates: 5, speed: 8 %}}\n"
                                          "motion: {{rest_before: 20 s, run: 30 s, rest_after: 3 s}}\n",
                                          source_folder()));
  for (const char* seed : {"1", "2"}) {
    const Said said = run_program(program("simulate"),
                                  {"course.yaml", "--seed", seed, "--output", std::string("logs_") + seed}, folder);
    ASSERT_EQ(said.code, 0) << said.err;
    const YAML::Node run = YAML::LoadFile(folder / fmt::format("logs_{}/truth.json", seed))["run_s"];
    const double whole = 20 + run[1].as<double>() - run[0].as<double>() + 3;
    EXPECT_TRUE(contains(said.out, fmt::format(": {:.0f} s", whole))) << whole << ": " << said.out;
    EXPECT_GT(std::abs(whole - 53), 0.6);
    folder.write(fmt::format("run_{}.yaml", seed),
                 fmt::format("imu: {{file: logs_{0}/mt9a_1.csv, sensor: {1}/config/sensors/xsens_mt9a.yaml}}\n"
                             "gnss: {{file: logs_{0}/gnss.csv, lever_arm: -0.06 0.03 -0.42 m}}\n"
                             "estimate: [gyro_bias, accel_bias, gyro_drift, accel_drift, gyro_scale, accel_scale]\n",
                             seed, source_folder()));
  }
  EXPECT_EQ(read_text(folder / "logs_1/gates.csv"), read_text(folder / "logs_2/gates.csv"));
  const Said said = run_program(program("descents"),
                                {"run_1.yaml", "run_2.yaml", "--gates", "logs_1/gates.csv", "--output", "out"}, folder);
  ASSERT_EQ(said.code, 0) << said.err;
  const YAML::Node found = YAML::LoadFile(folder / "out/descents.json");
  std::vector<YAML::Node> times;
  for (const char* seed : {"1", "2"}) {
    times.push_back(YAML::LoadFile(folder / fmt::format("logs_{}/truth.json", seed))["gates_time_s"]);
    ASSERT_EQ(times.back().size(), 5u);
  }
  const auto since = [&](std::size_t run, const std::string& gate) {
    return times[run][gate].as<double>() - times[run]["gate_1"].as<double>();
  };
  double most = 0;
  for (const YAML::Node& gate : found["gates"]) {
    const auto name = gate["name"].as<std::string>();
    const YAML::Node& at = gate["runs"]["run_2"];
    const double truth = since(0, name) - since(1, name), sigma = at["sigma_gained_s"].as<double>();
    EXPECT_LE(std::abs(at["gained_s"].as<double>() - truth), 5 * sigma) << name;
    EXPECT_LT(sigma, 1e-3);
    most = std::max(most, std::abs(truth));
  }
  EXPECT_GT(most, 0.05);
}

}  // namespace
}  // namespace piste::test
