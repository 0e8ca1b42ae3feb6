#include "piste/search/rounds.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <string>

#include "piste/configuration/sensor_file.h"
#include "piste/core/error.h"
#include "piste/io/config.h"
#include "piste/search/inspect.h"
#include "support/places.h"
#include "support/text_file.h"

namespace piste::test {
namespace {

// The shipped run, whose calibration is right, and its configuration.
class Rounds : public testing::Test {
 protected:
  ReplayConfig configured(const Inspection& now) {
    folder_.write("sensor.yaml", sensor_text(guess_sensor(now)));
    return read_replay_config(
        Config::parse(*ready_config(now, folder_.path().string(), "sensor.yaml"), folder_.path() / "replay.yaml"));
  }
  static const Inspection& shipped() {
    static const std::string run = (kSource / "data/ski_run/").string();
    static const Inspection found = inspect({run + "mt9a_1.csv", run + "gnss.csv"});
    return found;
  }
  static Calibration& calibration(Inspection& found) { return *found.logs[*found.first(LogKind::kGnss)].calibration; }

 private:
  TemporaryFolder folder_;
};

TEST_F(Rounds, TheConfigurationTakesWhatItsVerdictFinds) {
  Inspection found = shipped();
  ASSERT_TRUE(found.calibration() != nullptr);
  const auto replayed = [this](const Inspection& now) { return configured(now); };
  take_causes(found, replayed);
  ASSERT_EQ(found.rounds.size(), 1u);
  EXPECT_EQ(found.rounds[0].verdict, "sigmas hold");
  EXPECT_EQ(found.rounds[0].taken, "");
  // Nor is it too sure of what it does without fixes.
  widen_by_withheld(found, replayed);
  EXPECT_EQ(found.rounds.size(), 1u);

  const double right = calibration(found).sigma_scales.velocity;
  calibration(found).sigma_scales.velocity /= 4;
  take_causes(found, replayed);
  ASSERT_GE(found.rounds.size(), 2u);
  EXPECT_NE(found.rounds.front().verdict, "sigmas hold");
  EXPECT_EQ(found.rounds.back().verdict, "sigmas hold");
  for (std::size_t i = 0; i + 1 < found.rounds.size(); ++i) EXPECT_GT(found.rounds[i].gain, 3);
  EXPECT_TRUE(std::any_of(found.rounds.begin(), found.rounds.end(),
                          [](const auto& r) { return contains(r.taken, "gnss[0].velocity"); }));
  EXPECT_LT(std::abs(std::log(calibration(found).sigma_scales.velocity / right)), std::log(1.5));
}

// An IMU said to be far too good: as each fix corrects what it does, the innovations hardly show it. With and without a
// slow error of the receiver.
// Where the fixes would have the clock drift by 800 ppm, which none does, no round takes that.
TEST_F(Rounds, ADriftThatNoClockHasIsNotTaken) {
  const std::filesystem::path run = kSource / "data/ski_run";
  const TemporaryFolder logs;
  std::ifstream in(run / "mt9a_1.csv");
  std::string text, line;
  double first = 0;
  for (int row = 0; std::getline(in, line); ++row) {
    const std::size_t comma = line.find(',');
    if (row > 0) {
      const double t = std::stod(line.substr(0, comma));
      if (row == 1) first = t;
      line = fmt::format("{:.6f}{}", t + 8e-4 * (t - first), line.substr(comma));
    }
    text += line + "\n";
  }
  logs.write("imu.csv", text);
  Inspection found = inspect({(logs.path() / "imu.csv").string(), (run / "gnss.csv").string()});
  ASSERT_TRUE(found.calibration() != nullptr);
  take_causes(found, [this](const Inspection& now) { return configured(now); });
  EXPECT_LT(std::abs(calibration(found).clock_drift), 3.5e-4);
  EXPECT_NE(found.rounds.back().verdict, "sigmas hold");
}

TEST_F(Rounds, WhatIsTooSureWithoutFixesIsWidened) {
  for (const double share : {0.0, 0.6}) {
    Inspection found = shipped();
    ASSERT_TRUE(found.calibration() != nullptr);
    if (share > 0) calibration(found).drift = PositionDrift::of_share(Vector3d::Constant(share), kSlowTime);
    ImuSensor& sensor = calibration(found).sensor;
    const ImuSensor right = sensor;
    for (TriadErrors* triad : {&sensor.gyro, &sensor.accel}) {
      triad->noise /= 20;
      triad->drift.sigma /= 20;
    }
    found.rounds = {{.verdict = "sigmas hold"}};
    widen_by_withheld(found, [this](const Inspection& now) { return configured(now); });
    ASSERT_EQ(found.rounds.size(), 2u) << share;
    EXPECT_TRUE(contains(found.rounds.front().taken, "noise and drift of the IMU times")) << found.rounds.front().taken;
    EXPECT_EQ(found.suspicions.front().fault, LogFault::kDoesNotHold);
    EXPECT_GT(sensor.accel.noise, 3 * right.accel.noise / 20) << share;
  }
}

TEST_F(Rounds, NothingChangesWhereNoReplayRuns) {
  Inspection found;
  found.rounds.push_back({.verdict = "of an earlier call"});
  take_causes(found, [](const Inspection&) { return ReplayConfig{}; });
  EXPECT_TRUE(found.rounds.empty());
  found.rounds.push_back({.verdict = "of an earlier call"});
  take_causes(found, [](const Inspection&) -> ReplayConfig { throw ConfigError("a.csv", "there is no file"); });
  EXPECT_TRUE(found.rounds.empty());
}

}  // namespace
}  // namespace piste::test
