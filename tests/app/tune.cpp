// `tune` as its user sees it: what it writes, says and returns.

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <yaml-cpp/yaml.h>

#include "support/places.h"
#include "support/program.h"
#include "support/text_file.h"

namespace piste::test {
namespace {

// A part of the shipped run, by a configuration beside it.
std::string part_of_ski_run(const TemporaryFolder& folder, const std::string& more = "") {
  folder.write("part.yaml", fmt::format("base: {}/config/ski_run.yaml\nspan: {{start: 302490 s, end: 302550 s}}\n{}",
                                        kSource.string(), more));
  return "part.yaml";
}

TEST(Tune, WritesAConfigurationThatReplaysWithWhatItFound) {
  const TemporaryFolder folder;
  const Said said = run_program(program("tune"), {part_of_ski_run(folder), "--output", "tuned"}, folder);
  ASSERT_EQ(said.code, 0) << said.err;
  EXPECT_EQ(said.err, "");
  EXPECT_TRUE(contains(said.out, "gyro.noise"));
  EXPECT_TRUE(contains(said.out, "mean NIS of gnss[0].position"));

  const YAML::Node json = YAML::LoadFile(folder / "tuned/tune.json");
  for (const auto& n : json["noises"]) {
    const std::string name = n.first.as<std::string>();
    EXPECT_LT(n.second["interval"][0].as<double>(), n.second["value"].as<double>()) << name;
    EXPECT_GT(n.second["interval"][1].as<double>(), n.second["value"].as<double>()) << name;
    EXPECT_GT(n.second["start"].as<double>(), 0) << name;
  }
  EXPECT_NEAR(json["noises"]["gyro.noise"]["value"].as<double>(), 0.05, 0.02);
  EXPECT_NEAR(json["noises"]["gnss[0].sigma_scale"]["value"].as<double>(), 1, 0.15);
  EXPECT_GT(json["log_likelihood"]["found"].as<double>(), json["log_likelihood"]["start"].as<double>());

  const YAML::Node config = YAML::LoadFile(folder / "tuned/replay.yaml"),
                   sensor = YAML::LoadFile(folder / "tuned/sensor.yaml");
  EXPECT_EQ(config["imu"]["sensor"].as<std::string>(), "sensor.yaml");
  EXPECT_EQ(sensor["gyro"]["noise"].as<std::string>(),
            fmt::format("{:.3g} deg/s/sqrt(Hz)", json["noises"]["gyro.noise"]["value"].as<double>()));
  const Said again = run_program(program("replay"), {"tuned/replay.yaml", "--output", "replayed"}, folder);
  ASSERT_EQ(again.code, 0) << again.err;
  EXPECT_TRUE(contains(again.out, "sigmas hold")) << again.out;
}

// A receiver that stands alone, not in a list, and whose sigmas are stated three times too large, of heights 30 times.
TEST(Tune, StatesWhatItFoundOfAReceiverThatStandsAlone) {
  const TemporaryFolder folder;
  const std::string config =
      part_of_ski_run(folder, fmt::format("gnss: {{file: {}/data/ski_run/gnss.csv, format: csv, lever_arm: -0.06 0.03 "
                                          "-0.42 m, use: position velocity, sigma_scale: 3, sigma_height_scale: 10}}\n",
                                          kSource.string()));
  const Said said = run_program(program("tune"), {config, "--output", "tuned", "--hold-out", "10"}, folder);
  ASSERT_EQ(said.code, 0) << said.err;
  EXPECT_TRUE(contains(said.out, "mean NIS of gnss[0].position, held out: ")) << said.out;
  EXPECT_TRUE(contains(said.out, " ± 0.")) << said.out;
  const YAML::Node gnss = YAML::LoadFile(folder / "tuned/replay.yaml")["gnss"];
  ASSERT_TRUE(gnss && gnss.IsMap());
  EXPECT_NEAR(gnss["sigma_scale"].as<double>(), 1, 0.15);
  EXPECT_NEAR(gnss["sigma_height_scale"].as<double>(), 1, 0.2);
  const Said again = run_program(program("replay"), {"tuned/replay.yaml", "--output", "replayed"}, folder);
  ASSERT_EQ(again.code, 0) << again.err;
  EXPECT_TRUE(contains(again.out, "sigmas hold")) << again.out;
}

TEST(Tune, SaysWhatIsWrong) {
  const TemporaryFolder folder;
  const auto said = [&](const std::string& more) {
    return run_program(program("tune"), {part_of_ski_run(folder, more), "--output", "tuned"}, folder);
  };
  EXPECT_EQ(said("sigma_scael: 2\n").code, 2);
  const Said wrong =
      said(fmt::format("gnss: {{file: {}/data/ski_run/gnss.csv, format: csv, sigma_scale: -1}}\n", kSource.string()));
  EXPECT_EQ(wrong.code, 2);
  EXPECT_TRUE(contains(wrong.err, "part.yaml:3")) << wrong.err;
  EXPECT_TRUE(contains(wrong.err, "above zero")) << wrong.err;
  EXPECT_EQ(run_program(program("tune"), {"nothing.yaml"}, folder).code, 2);
}

}  // namespace
}  // namespace piste::test
