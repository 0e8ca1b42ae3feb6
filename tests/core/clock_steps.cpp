// Clocks that are set while they run.

#include <gtest/gtest.h>

#include <vector>

#include "core/recording.h"
#include "support/text_file.h"

namespace piste {
namespace {

using test::contains;
using test::message_of;

// The times of an IMU of 40 Hz whose clock jumps by `step` behind row 400.
std::vector<double> stepped(double step) {
  std::vector<double> time;
  for (int i = 0; i < 1000; ++i) time.push_back(50 + 0.025 * i + (i > 400 ? step : 0));
  return time;
}

ImuRecording recording(std::vector<double> time) {
  ImuRecording imu;
  imu.file = "imu.csv";
  imu.gyro.assign(time.size(), Vector3d::Zero());
  imu.accel.assign(time.size(), Vector3d::UnitZ());
  imu.time = std::move(time);
  return imu;
}

TEST(ClockSteps, AClockThatIsSetBackOnceIsFound) {
  const auto steps = clock_steps(stepped(-1.25));
  ASSERT_EQ(steps.size(), 1U);
  EXPECT_DOUBLE_EQ(steps[0].time, 60);
  EXPECT_NEAR(steps[0].step, -1.25, 1e-9);
  ImuRecording imu = recording(stepped(-1.25));
  take_out_steps(imu, steps);
  for (std::size_t i = 0; i < imu.time.size(); ++i) EXPECT_NEAR(imu.time[i], stepped(0)[i], 1e-9) << i;
}

TEST(ClockSteps, RowsOutOfOrderAreNone) {
  std::vector<double> swapped = stepped(0), late = stepped(0), again = stepped(0);
  std::swap(swapped[500], swapped[501]);
  late.insert(late.begin() + 700, late[650]);
  again.insert(again.end(), again.begin(), again.begin() + 500);
  EXPECT_TRUE(clock_steps(stepped(0)).empty());
  EXPECT_TRUE(clock_steps(swapped).empty());
  EXPECT_TRUE(clock_steps(late).empty());
  EXPECT_TRUE(clock_steps(again).empty()) << "the log stands in the file twice";
}

TEST(ClockSteps, StatedStepsMayGoForwardAndMustBeThere) {
  ImuRecording imu = recording(stepped(0.8));
  take_out_steps(imu, {{60, 0.8}});
  EXPECT_NEAR(imu.time.back(), stepped(0).back(), 1e-9);
  EXPECT_TRUE(contains(message_of<DataError>([&] { take_out_steps(imu, {{60, 0.8}}); }), "names a step of +0.8 s"));
}

}  // namespace
}  // namespace piste
