#include "experiment/settling.h"

#include <gtest/gtest.h>

#include <utility>

#include "support/simulated_case.h"

namespace piste::test {
namespace {

struct Told {
  Case run = make_case("easy_ski", 40, 1);
  Recording recording = run.simulation.recording(0);
  bool find_clock = true;
  Calibration calibration{.lever_arm = run.options.gnss[0].lever_arm,
                          .lever_arm_sigma = Vector3d::Constant(0.01),
                          .clock_offset = run.conditioning.imu.clock_offset,
                          .clock_sigma = 0.01,
                          .clock_drift = run.conditioning.imu.clock_drift,
                          .sensor = run.options.sensor};

  std::optional<Calibration> settle() const {
    return settled(recording, run.conditioning, run.options, std::nullopt, find_clock, calibration);
  }
};

TEST(Settling, LeavesWhatHolds) {
  const Told told;
  const auto found = told.settle();
  ASSERT_TRUE(found);
  EXPECT_EQ(found->sigma_scale, 1);
  EXPECT_EQ(found->sigma_velocity_scale, 1);
  EXPECT_NEAR(found->clock_offset, told.calibration.clock_offset, 1e-3);
}

// A receiver that claims a third of its errors: its sigmas grow until the gate takes 99 of 100 fixes. Their tails are
// then inside, which is all that is asked for.
TEST(Settling, SigmasThatRefuseFixesGrow) {
  Told told;
  scale_sigmas(told.recording.gnss.front(), 1.0 / 3, 1.0 / 3);
  const auto found = told.settle();
  ASSERT_TRUE(found);
  EXPECT_GT(found->sigma_scale, 1.5);
  EXPECT_GT(found->sigma_velocity_scale, 1.5);
  EXPECT_LT(found->sigma_scale, 4.5);
  EXPECT_LT(found->sigma_velocity_scale, 4.5);
}

TEST(Settling, TheClockTakesTheDelayOfTheFixes) {
  Told told;
  told.calibration.clock_offset += 0.015;
  const auto found = told.settle();
  ASSERT_TRUE(found);
  EXPECT_NEAR(found->clock_offset, told.run.conditioning.imu.clock_offset, 1e-3);
}

TEST(Settling, AClockThatIsKnownStays) {
  Told told;
  told.calibration.clock_offset += 0.015;
  told.find_clock = false;
  const auto found = told.settle();
  ASSERT_TRUE(found);
  EXPECT_EQ(found->clock_offset, told.calibration.clock_offset);
}

TEST(Settling, SaysWhereNoFilterRuns) {
  Told told;
  told.recording.gnss.front().fixes.clear();
  EXPECT_FALSE(told.settle());
}

}  // namespace
}  // namespace piste::test
