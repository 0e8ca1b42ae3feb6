// `simulate` of a campaign as its user sees it: a folder that stands alone, and the same bytes from the same seed.

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <yaml-cpp/yaml.h>

#include <map>

#include "piste/configuration/sensor_file.h"
#include "piste/io/log_io.h"
#include "support/places.h"
#include "support/program.h"

namespace piste::test {
namespace {

namespace fs = std::filesystem;

/// The shipped campaign's first ski run and first lap, a few seconds of each.
class SimulateCampaign : public testing::Test {
 protected:
  void SetUp() override {
    const std::string motion = "motion: {rest_before: 2 s, run: 13 s, rest_after: 1 s, net_turn: 40 deg}";
    const std::string shipped = source_folder() + "/config/scenarios/campaign";
    folder_.write("short.yaml", fmt::format("base: {0}.yaml\nruns:\n"
                                            "  - {{name: ski-1, activity: ski, scenario: {0}/ski.yaml, {1}}}\n"
                                            "  - {{name: lap, activity: bicycle, scenario: {0}/bicycle.yaml, {1}}}\n",
                                            shipped, motion));
  }
  Said simulate(std::vector<std::string> words) const {
    words.insert(words.begin(), "short.yaml");
    return run_program(program("simulate"), words, folder_);
  }
  std::map<std::string, std::string> files(const std::string& name) const {
    std::map<std::string, std::string> found;
    for (const auto& entry : fs::recursive_directory_iterator(folder_.path() / name)) {
      if (entry.is_regular_file()) {
        found[fs::relative(entry.path(), folder_.path() / name).string()] = read_text(entry.path());
      }
    }
    return found;
  }

  TemporaryFolder folder_;
};

TEST_F(SimulateCampaign, WritesAFolderThatStandsAlone) {
  const Said said = simulate({"--output", "made"});
  ASSERT_EQ(said.code, 0) << said.err;
  EXPECT_EQ(said.err, "");
  EXPECT_TRUE(contains(said.out, "2 runs"));
  EXPECT_TRUE(contains(said.out, "made/campaign.yaml"));
  fs::rename(folder_.path() / "made", folder_.path() / "moved");
  const fs::path moved = folder_.path() / "moved";
  const YAML::Node campaign = YAML::LoadFile((moved / "campaign.yaml").string());
  ASSERT_EQ(campaign["runs"].size(), 2U);
  for (const YAML::Node& run : campaign["runs"]) {
    const YAML::Node truth = YAML::LoadFile((moved / run["truth"].as<std::string>()).string());
    ASSERT_EQ(run["mems"].size(), 3U);
    std::vector<YAML::Node> imus{run["reference"]};
    for (const YAML::Node& mems : run["mems"]) imus.push_back(mems);
    for (const YAML::Node& imu : imus) {
      const fs::path file = imu["file"].as<std::string>();
      EXPECT_GE(read_imu(LogFile{(moved / file).string()}).time.size(), 1599U);
      EXPECT_TRUE(truth["imus"][file.stem().string()]) << file;
      EXPECT_GT(read_sensor(moved / imu["sensor"].as<std::string>()).gyro.noise, 0);
    }
    EXPECT_EQ(read_gnss({(moved / run["gnss"]["file"].as<std::string>()).string()}).fixes.size(), 161U);
    EXPECT_TRUE(fs::exists(moved / run["name"].as<std::string>() / "truth.csv"));
  }
  EXPECT_EQ(campaign["runs"][1]["activity"].as<std::string>(), "bicycle");
  for (const auto& [name, text] : files("moved")) EXPECT_FALSE(name.ends_with(".partial")) << name;
}

TEST_F(SimulateCampaign, SameSeedSameBytes) {
  ASSERT_EQ(simulate({"--output", "a", "--quiet"}).code, 0);
  ASSERT_EQ(simulate({"--output", "b", "--quiet"}).code, 0);
  ASSERT_EQ(simulate({"--output", "c", "--quiet", "--seed", "1"}).code, 0);
  const auto a = files("a");
  EXPECT_TRUE(a == files("b"));
  EXPECT_EQ(a.size(), 2U * 12 + 2 + 2) << "logs, sensors, the campaign and the article that it names";
  const auto c = files("c");
  EXPECT_NE(a.at("lap/mt9a_2.csv"), c.at("lap/mt9a_2.csv"));
  const auto bias = [](const std::string& truth) {
    return YAML::Load(truth)["imus"]["mt9a_2"]["accel"]["bias_m_s2"][0].as<double>();
  };
  EXPECT_NE(bias(a.at("lap/truth.json")), bias(c.at("lap/truth.json"))) << "a spread is drawn anew";
  EXPECT_NE(bias(a.at("lap/truth.json")), bias(a.at("ski-1/truth.json"))) << "every run has its own seed";
}

TEST_F(SimulateCampaign, LeavesNothingWhereItIsRefused) {
  folder_.write("short.yaml", read_text(folder_ / "short.yaml") + "low_pas: 12 Hz\n");
  const Said said = simulate({"--output", "made"});
  EXPECT_EQ(said.code, 2);
  EXPECT_TRUE(contains(said.err, "short.yaml:5: unknown key `low_pas`, perhaps `low_pass`"));
  EXPECT_FALSE(fs::exists(folder_.path() / "made"));
}

}  // namespace
}  // namespace piste::test
