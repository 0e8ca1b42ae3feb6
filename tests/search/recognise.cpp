// Which files make an IMU together.

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "piste/search/inspect.h"
#include "support/random.h"
#include "support/text_file.h"

namespace piste {
namespace {

/// The folder of a phone's recorder: a file a sensor, with columns x, y, z.
struct PhoneFolder : ::testing::Test {
  test::TemporaryFolder folder;

  std::string sensor(const std::string& name, const Vector3d& mean, double noise) const {
    std::string text = "time,seconds_elapsed,z,y,x\n";
    test::Random random(1);
    const auto next = [&](double about) { return about + noise * (random.uniform() - 0.5); };
    for (int i = 0; i < 1000; ++i) {
      text += fmt::format("{}{:09d},{:.2f},{:.6f},{:.6f},{:.6f}\n", 1700000000 + i / 50, i % 50 * 20000000, 0.02 * i,
                          next(mean.z()), next(mean.y()), next(mean.x()));
    }
    return folder.write(name, text);
  }
  std::string gyroscope() const { return sensor("Gyroscope.csv", Vector3d::Zero(), 0.01); }
  std::string without_gravity() const { return sensor("Accelerometer.csv", Vector3d::Zero(), 0.1); }
  std::string total() const { return sensor("TotalAcceleration.csv", {0, 0, -9.81}, 0.1); }
  std::string gravity() const { return sensor("Gravity.csv", {0, 0, -9.81}, 1e-6); }
};

TEST_F(PhoneFolder, MakesOneImuOfTheForcesWithGravityAndNoise) {
  std::vector<Suspicion> found;
  const auto logs = recognise({without_gravity(), gravity(), gyroscope(), sensor("Magnetometer.csv", {20, 5, -40}, 1),
                               sensor("AccelerometerUncalibrated.csv", {0, 0, -9.81}, 0.1), total(),
                               sensor("GyroscopeUncalibrated.csv", Vector3d::Zero(), 0.01)},
                              found);
  const auto is_whole = [](const InspectedLog& l) { return l.guess.has_value(); };
  ASSERT_EQ(std::count_if(logs.begin(), logs.end(), is_whole), 1);
  const InspectedLog& imu = *std::find_if(logs.begin(), logs.end(), is_whole);
  EXPECT_EQ(imu.log.file, folder / "Gyroscope.csv");
  EXPECT_EQ(imu.log.accel_file, folder / "TotalAcceleration.csv");
  ASSERT_EQ(found.size(), 5U);
  for (const Suspicion& s : found) EXPECT_EQ(s.fault, LogFault::kNotUsed) << s.file << ": " << s.what;
  for (const InspectedLog& l : logs) EXPECT_EQ(l.left_out.empty(), is_whole(l)) << l.log.file;
}

TEST_F(PhoneFolder, AddsGravityToForcesWithoutIt) {
  std::vector<Suspicion> found;
  const auto logs = recognise({gravity(), gyroscope(), without_gravity()}, found);
  ASSERT_EQ(logs.size(), 1U);
  EXPECT_EQ(logs[0].log.accel_file, folder / "Accelerometer.csv");
  EXPECT_EQ(logs[0].log.gravity_file, folder / "Gravity.csv");
  EXPECT_TRUE(found.empty());
  const ImuRecording imu = read_imu(logs[0].log);
  EXPECT_NEAR(imu.accel.at(500).z(), -9.81, 0.1);
  EXPECT_GT((imu.accel[500] - imu.accel[501]).norm(), 1e-3) << "with the sensor's noise";
}

// In rows of one file, of which only one kind could be named for both.
TEST_F(PhoneFolder, AddsNoGravityThatStandsInOtherRows) {
  std::string text = "sensor,time_ms,x,y,z\n";
  test::Random random(2);
  const auto row = [&](const char* kind, int i, double z) {
    text +=
        fmt::format("{},{},{:.5f},{:.5f},{:.5f}\n", kind, 20 * i, 0.1 * random.uniform(), 0.1 * random.uniform(), z);
  };
  for (int i = 0; i < 1000; ++i) {
    row("gyroscope", i, 0.01 * (i % 7));
    row("linear_acceleration", i, 0.1 * (i % 5));
    row("gravity", i, 9.8);
  }
  std::vector<Suspicion> found;
  for (const InspectedLog& l : recognise({folder.write("all.csv", text)}, found))
    EXPECT_TRUE(l.log.gravity_file.empty());
}

TEST_F(PhoneFolder, TakesForcesWithoutGravityWhereThereAreNoOthers) {
  std::vector<Suspicion> found;
  const auto logs = recognise({gyroscope(), without_gravity()}, found);
  ASSERT_EQ(logs.size(), 1U);
  EXPECT_EQ(logs[0].log.accel_file, folder / "Accelerometer.csv");
  EXPECT_TRUE(test::contains(logs[0].guess->doubts.back(), "accelerations without gravity"));
  EXPECT_TRUE(found.empty());
}

TEST_F(PhoneFolder, NamesHalfAnImu) {
  std::vector<Suspicion> found;
  recognise({gravity()}, found);
  ASSERT_EQ(found.size(), 1U);
  EXPECT_EQ(found[0].fault, LogFault::kUnreadable);
}

TEST_F(PhoneFolder, ImuAndReceiverOfOneFileAreTwoLogs) {
  std::string text = "time,gx,gy,gz,ax,ay,az,lat,lon,alt\n";
  for (int i = 0; i < 500; ++i) {
    text += fmt::format("{:.2f},0.0{},0.01,0.02,0.1,0.{},-9.8,46.5,6.{},400\n", 0.02 * i, i % 7, i % 5, 600 + i / 50);
  }
  std::vector<Suspicion> found;
  const auto logs = recognise({folder.write("all.csv", text)}, found);
  ASSERT_EQ(logs.size(), 2U);
  EXPECT_TRUE(logs[0].is(LogKind::kImu));
  EXPECT_TRUE(logs[1].is(LogKind::kGnss));
  EXPECT_EQ(logs[0].log.file, logs[1].log.file);
  RowFaults faults;
  EXPECT_EQ(read_gnss(logs[1].log, &faults).fixes.size(), 10U);
  EXPECT_EQ(faults.total(), 0U);
}

}  // namespace
}  // namespace piste
