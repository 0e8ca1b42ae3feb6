// Rows that share a stamp, as of a clock that counts whole seconds.

#include <gtest/gtest.h>

#include <cmath>

#include "core/recording.h"

namespace piste {
namespace {

ImuRecording stamped(const std::vector<double>& time) {
  ImuRecording imu;
  imu.time = time;
  imu.gyro.assign(time.size(), Vector3d::Zero());
  imu.accel.assign(time.size(), Vector3d(0, 0, -9.8));
  return imu;
}

TEST(SpreadStamps, RowsLieEvenlyUpToTheNextStamp) {
  ImuRecording imu = stamped({10, 10, 10, 10, 11, 11, 11, 11, 12, 12, 12, 12});
  spread_stamps(imu);
  for (std::size_t i = 0; i < imu.time.size(); ++i) EXPECT_NEAR(imu.time[i], 10 + 0.25 * static_cast<double>(i), 1e-12);
}

// The log begins within a second and ends within one, and a hole of two seconds is one still.
TEST(SpreadStamps, EndsAndGapsKeepTheUsualPace) {
  ImuRecording imu = stamped({10, 11, 11, 11, 11, 12, 12, 12, 12, 13, 13, 13, 13, 16, 16, 16, 16, 17, 17});
  spread_stamps(imu);
  EXPECT_NEAR(imu.time[0], 10.75, 1e-12);
  EXPECT_NEAR(imu.time[12], 13.75, 1e-12);
  EXPECT_NEAR(imu.time[13], 16, 1e-12);
  EXPECT_NEAR(imu.time[18], 17.25, 1e-12);
}

TEST(SpreadStamps, RowsOfOneStampStandTogether) {
  ImuRecording imu = stamped({10, 10, 11, 10, 10, 11, 11, 11, 12, 12, 12, 12});
  imu.gyro[3].x() = 1;
  spread_stamps(imu);
  for (std::size_t i = 0; i < imu.time.size(); ++i) EXPECT_NEAR(imu.time[i], 10 + 0.25 * static_cast<double>(i), 1e-12);
  EXPECT_EQ(imu.gyro[2].x(), 1) << "with its row";
}

TEST(SpreadStamps, StampsOfTheirOwnStay) {
  const std::vector<double> time{1, 1.01, 1.02, 1.05};
  ImuRecording imu = stamped(time);
  spread_stamps(imu);
  EXPECT_EQ(imu.time, time);
}

TEST(SpreadStamps, FixesToo) {
  GnssRecording gnss;
  for (const double t : {5.0, 5.0, 6.0, 6.0, 7.0, 7.0}) {
    GeodeticFix& fix = gnss.fixes.emplace_back();
    fix.time = t;
  }
  spread_stamps(gnss);
  EXPECT_NEAR(gnss.fixes[3].time, 6.5, 1e-12);
}

}  // namespace
}  // namespace piste
