#include "piste/search/readings.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "piste/configuration/sensor_file.h"
#include "piste/core/error.h"
#include "piste/io/config.h"
#include "piste/search/inspect.h"
#include "support/places.h"
#include "support/text_file.h"

namespace piste::test {
namespace {

class Readings : public testing::Test {
 protected:
  void weigh(Inspection& found) {
    weigh_readings(found, [this](const Inspection& now) {
      folder_.write("sensor.yaml", sensor_text(guess_sensor(now)));
      return read_replay_config(Config::parse(text(now), folder_.path() / "replay.yaml"));
    });
  }
  std::string text(const Inspection& now) const { return *ready_config(now, folder_.path().string(), "sensor.yaml"); }

  static Inspection shipped() {
    static const std::string run = (kSource / "data/ski_run/").string();
    static const Inspection found = inspect({run + "mt9a_1.csv", run + "gnss.csv"});
    return found;
  }
  static LogMatch& match(Inspection& found) { return found.matches.front().match; }

 private:
  TemporaryFolder folder_;
};

// It sits askew on a skier's back, between two sets of axes: no other doubt is left of it.
TEST_F(Readings, ARightOneLeavesNoDoubtOfWhatTheLogsTell) {
  Inspection found = shipped();
  ASSERT_FALSE(match(found).motion->as_likely.empty());
  match(found).motion->as_likely.clear();
  weigh(found);
  EXPECT_TRUE(found.doubts.empty());
}

// Where the motion tells no axes, gravity leaves four, and a run is as likely with each: none of them is kept in
// silence.
TEST_F(Readings, AxesThatGravityLeavesAreADoubt) {
  Inspection found = shipped();
  match(found).motion.reset();
  const Matrix3d before = guess_conditioning(found).R_bs;
  weigh(found);
  ASSERT_EQ(found.doubts.size(), 1u);
  const InspectedDoubt& doubt = found.doubts.front();
  ASSERT_EQ(doubt.readings.size(), 4u);
  EXPECT_EQ(doubt.readings.front().keys, "axes: " + axes_text(before));
  for (const InspectedReading& reading : doubt.readings) {
    EXPECT_NEAR(reading.ln_p, doubt.readings.front().ln_p, std::log(4) + 3) << reading.keys;
    EXPECT_NE(reading.ln_p, 0);
    EXPECT_TRUE(contains(text(found), reading.keys)) << text(found);
  }
  EXPECT_TRUE(std::any_of(found.suspicions.begin(), found.suspicions.end(),
                          [](const Suspicion& s) { return s.fault == LogFault::kDoubt; }));
}

// Velocities that were left out, though they agree with the positions: the whole log tells.
TEST_F(Readings, TheLikelierOneIsTaken) {
  Inspection found = shipped();
  match(found).motion->as_likely.clear();
  found.logs[*found.first(LogKind::kGnss)].calibration->velocities_contradict = true;
  ASSERT_FALSE(contains(text(found), "use: position velocity"));
  weigh(found);
  EXPECT_TRUE(contains(text(found), "use: position velocity"));
  EXPECT_TRUE(found.doubts.empty());
  EXPECT_TRUE(std::any_of(found.suspicions.begin(), found.suspicions.end(), [](const Suspicion& s) {
    return s.fault == LogFault::kDoubt && contains(s.what, "of ln p likelier than `use: position`");
  }));
}

TEST_F(Readings, NoneIsWeighedWhereNoReplayRuns) {
  Inspection found = shipped();
  match(found).motion.reset();
  weigh_readings(found, [](const Inspection&) -> ReplayConfig { throw ConfigError("a.csv", "there is no file"); });
  EXPECT_TRUE(found.doubts.empty());
}

}  // namespace
}  // namespace piste::test
