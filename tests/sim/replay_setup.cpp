#include "piste/sim/replay_setup.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>

#include "piste/configuration/sensor_file.h"
#include "piste/math/units.h"
#include "piste/sim/campaign.h"
#include "piste/sim/scenario.h"
#include "support/places.h"
#include "support/text_file.h"

namespace piste {
namespace {

using test::contains;
using test::message_of;

const std::filesystem::path kShipped = test::kSource / "config";
const std::filesystem::path kSuite = kShipped / "scenarios" / "montecarlo";

const std::vector<Block> kUsual = {Block::kGyroBias,   Block::kAccelBias, Block::kGyroDrift,
                                   Block::kAccelDrift, Block::kGyroScale, Block::kAccelScale};

std::vector<Block> usual_and(std::initializer_list<Block> more) {
  std::vector<Block> blocks = kUsual;
  blocks.insert(blocks.end(), more);
  return blocks;
}

ReplaySetup shipped_setup(const std::string& name) { return read_scenario(kSuite / (name + ".yaml")).replay; }

class ReplaySetupTest : public testing::Test {
 protected:
  // The ski run, and what a file says beyond it, from its third line on.
  Scenario read(const std::string& text) {
    const std::string base = (kShipped / "scenarios" / "ski.yaml").string();
    return read_scenario(folder_.write("run.yaml", "base: " + base + "\nseed: 3\n" + text));
  }
  std::string refusal(const std::string& text) {
    return message_of<ConfigError>([&] { read(text); });
  }

  test::TemporaryFolder folder_;
};

TEST_F(ReplaySetupTest, Defaults) {
  const Scenario s = read("");
  EXPECT_EQ(s.replay.imu, 0u);
  EXPECT_EQ(s.replay.gnss, std::vector<std::size_t>{0});
  EXPECT_TRUE(s.replay.attitude.empty());
  EXPECT_EQ(s.replay.sensor.name, s.imus[0].sensor.name);
  EXPECT_EQ(s.replay.estimate, kUsual);
  EXPECT_EQ(s.replay.heading, ReplaySetup::Heading::kKnown);
  EXPECT_FALSE(s.replay.random_headings);
  EXPECT_EQ(s.replay.start.velocity, 0.05);
  EXPECT_NEAR(s.replay.start.tilt * kDegreesPerRadian, 0.33, 1e-12);
  EXPECT_TRUE(s.replay.outages.empty());
  EXPECT_EQ(s.replay.every, 1);
}

TEST_F(ReplaySetupTest, ReadsEveryKeyInItsUnit) {
  folder_.write("told.yaml",
                "name: told\ngyro: {noise: 0.1 deg/s/sqrt(Hz), bias: 1 deg/s}\naccel: {noise: 200 ug/sqrt(Hz)}\n");
  const ReplaySetup r = read(R"(
montecarlo:
  imu: mt9a_3
  gnss: [gnss_l1, gnss_l1l2]
  attitude: ln200_attitude
  sensor: told.yaml
  estimate: [accel_bias, gyro_bias, lever_arm]
  headings: random
  start: {position: 2 m, velocity: 10 cm/s, heading: 3 deg}
  outages: [[20 s, 10 s], [-5 s, 3 s]]
  every: 500 ms
)")
                            .replay;
  EXPECT_EQ(r.imu, 2u);
  EXPECT_EQ(r.gnss, (std::vector<std::size_t>{1, 0}));
  EXPECT_EQ(r.attitude, std::vector<std::size_t>{0});
  EXPECT_EQ(r.sensor.name, "told");
  EXPECT_EQ(r.estimate,
            (std::vector<Block>{Block::kGyroBias, Block::kLeverArm, Block::kGnssPositionDrift, Block::kAttitudeDrift}))
      << "the sensor that is told has no accelerometer bias; drifts of the sources are added";
  EXPECT_TRUE(r.random_headings);
  EXPECT_EQ(r.start.position, 2);
  EXPECT_NEAR(r.start.velocity, 0.1, 1e-15);
  EXPECT_NEAR(r.start.heading * kDegreesPerRadian, 3, 1e-12);
  EXPECT_EQ(r.start.tilt, StartSigmas().tilt);
  ASSERT_EQ(r.outages.size(), 2u);
  EXPECT_EQ(r.outages[0].end, 30);
  EXPECT_EQ(r.outages[1].start, -5);
  EXPECT_EQ(r.every, 0.5);
}

TEST_F(ReplaySetupTest, RefusesWithTheLineAndTheRemedy) {
  const std::pair<std::string, std::string> cases[] = {
      {"imu: mt9a_4", "run.yaml:4: imu: the scenario has no `mt9a_4`, perhaps `mt9a_1`; there are: mt9a_1, mt9a_2"},
      {"imu: []", "run.yaml:4: imu: one IMU"},
      {"gnss: gnss_l5", "there are: gnss_l1l2, gnss_l1"},
      {"gnss: []", "run.yaml:4: gnss: name at least one"},
      {"gnss: gnss_l1 gnss_l1", "run.yaml:4: gnss: `gnss_l1` stands twice"},
      {"attitude: ln200", "run.yaml:4: attitude: the scenario has no `ln200`"},
      {"sensor: none.yaml", "run.yaml:4: sensor: there is no file"},
      {"estimate: gyro_bais", "run.yaml:4: estimate: there is no state block `gyro_bais`, perhaps `gyro_bias`"},
      {"estimate: boresight", "run.yaml:4: estimate: boresight needs an `attitude:` source"},
      {"estimate: gnss_position_drift",
       "run.yaml:4: estimate: gnss_position_drift needs a `gnss:` source with a drift"},
      {"heading: guessed", "run.yaml:4: heading: `guessed` is none of: known, auto"},
      {"headings: south", "run.yaml:4: headings: `south` is none of: as_given, random"},
      {"start: {tilt: 0 deg}", "run.yaml:4: tilt: must be above zero"},
      {"start: {speed: 1 m/s}", "run.yaml:4: unknown key `speed`"},
      {"{heading: auto, start: {tilt: 1 deg}}", "run.yaml:4: key `start` has no use here"},
      {"outages: [[20 s, 0 s]]", "run.yaml:4: outages: "},
      {"outages: [[260 s, 20 s]]", "run.yaml:4: outages: [260, 20] leaves the recording"},
      {"every: 0 s", "run.yaml:4: every: must be above zero"},
      {"runs: 100", "run.yaml:4: unknown key `runs`"},
  };
  for (const auto& [line, expected] : cases) {
    EXPECT_TRUE(contains(refusal("montecarlo:\n  " + line + "\n"), expected)) << line;
  }
  EXPECT_TRUE(contains(refusal("gnss: []\nmontecarlo: {every: 1 s}\n"), "run.yaml:4: montecarlo: needs a receiver"));
  EXPECT_TRUE(read("gnss: []\n").replay.gnss.empty());
}

// Each receiver has a slow error of its own.
TEST_F(ReplaySetupTest, TwoReceiversDrift) {
  const std::vector<Block> estimate = read(R"(montecarlo: {gnss: [one, two], estimate: gyro_bias}
gnss:
  - {name: one, position_drift: {sigma: 1 1 1 m, correlation_time: 60 s}}
  - {name: two, position_drift: {sigma: 1 1 1 m, correlation_time: 60 s}}
)")
                                          .replay.estimate;
  EXPECT_EQ(estimate,
            (std::vector<Block>{Block::kGyroBias, Block::kGnssPositionDrift, position_drift_block(1, false)}));
}

TEST(MonteCarloSuite, EveryScenarioSaysHowItIsReplayed) {
  std::size_t files = 0;
  for (const auto& folder : {kShipped / "scenarios", kSuite}) {
    for (const auto& entry : std::filesystem::directory_iterator(folder)) {
      if (entry.path().extension() != ".yaml" || entry.path().stem() == "backpack") continue;  // that one has no motion
      if (is_campaign(entry.path())) continue;
      ++files;
      const Scenario s = read_scenario(entry.path());
      EXPECT_EQ(s.replay.gnss.size(), 1u) << entry.path();
      EXPECT_GE(s.replay.estimate.size(), kUsual.size()) << entry.path();
    }
  }
  EXPECT_GE(files, 5u + 14u);
}

TEST(MonteCarloSuite, ReplaysWhatItsNamesSay) {
  EXPECT_EQ(shipped_setup("ski_l1").gnss, std::vector<std::size_t>{1});
  EXPECT_EQ(shipped_setup("ski_l1").estimate, usual_and({Block::kGnssPositionDrift}));
  EXPECT_EQ(shipped_setup("bicycle_l1_attitude").estimate,
            usual_and({Block::kBoresight, Block::kGnssPositionDrift, Block::kAttitudeDrift}));
  EXPECT_EQ(shipped_setup("ski_l1l2_attitude").estimate, usual_and({Block::kBoresight, Block::kAttitudeDrift}));
  for (const char* name : {"ski_heading", "bicycle_heading", "ski_heading_l1", "ski_no_rest"}) {
    EXPECT_EQ(shipped_setup(name).heading, ReplaySetup::Heading::kAuto) << name;
    EXPECT_TRUE(shipped_setup(name).random_headings) << name;
  }
  EXPECT_EQ(shipped_setup("ski_heading_l1").gnss, std::vector<std::size_t>{1});
  EXPECT_EQ(read_scenario(kSuite / "ski_no_rest.yaml").motion.duration(), 90);
  EXPECT_EQ(shipped_setup("ski_outages").outages.size(), 3u);
}

TEST(MonteCarloSuite, TheWorseSensorIsTwiceAsNoisyAsTheFilterIsTold) {
  const Scenario s = read_scenario(kSuite / "ski_worse_sensor.yaml");
  const ImuSensor& simulated = s.imus[s.replay.imu].sensor;
  EXPECT_NEAR(simulated.gyro.noise / s.replay.sensor.gyro.noise, 2, 1e-12);
  EXPECT_NEAR(simulated.accel.noise / s.replay.sensor.accel.noise, 2, 1e-12);
  EXPECT_EQ(simulated.gyro.bias, s.replay.sensor.gyro.bias);
}

}  // namespace
}  // namespace piste
