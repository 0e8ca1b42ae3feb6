#include "piste/inspect/attitude_match.h"

#include <gtest/gtest.h>

#include <cmath>

#include "piste/inspect/log_match.h"
#include "piste/io/log_io.h"
#include "piste/math/units.h"
#include "support/places.h"
#include "support/text_file.h"

namespace piste::test {
namespace {

const ImuRecording& carried_imu() {
  static const ImuRecording imu = read_imu({source_folder() + "/data/ski_run/mt9a_1.csv", LogFormat::kCsv});
  return imu;
}

const AttitudeRecording& carried_attitude() {
  static const AttitudeRecording attitude =
      read_attitude({source_folder() + "/data/ski_run/ln200_attitude.csv", LogFormat::kCsv});
  return attitude;
}

AttitudeRecording later(double by) {
  AttitudeRecording attitude = carried_attitude();
  for (EulerFix& fix : attitude.fixes) fix.time += by;
  return attitude;
}

AttitudeRecording turned(const Quaterniond& q) {
  AttitudeRecording attitude = carried_attitude();
  for (EulerFix& fix : attitude.fixes) fix.angles = to_euler(from_euler(fix.angles) * q);
  return attitude;
}

std::vector<Suspicion> said_of(const AttitudeMatch& m) {
  return suspicions(m, Matrix3d::Identity(), "imu", "attitude");
}

void expect_fit(const AttitudeMatch& m, double offset) {
  ASSERT_TRUE(m.fit) << m.why_not;
  EXPECT_LT(m.fit->sigma_offset, 1e-3);
  EXPECT_NEAR(m.fit->offset, offset, 4 * m.fit->sigma_offset);
}

TEST(AttitudeMatch, FindsTheBoresightOfTheShippedRun) {
  const AttitudeMatch m = match(carried_imu(), carried_attitude());
  expect_fit(m, 0);
  const Vector3d truth(1.9, -2.4, 2.1);
  for (int i = 0; i < 3; ++i) {
    EXPECT_NEAR(to_euler(m.fit->left)(i) / kDegree, truth(i), 4 * m.fit->sigma_left(i) / kDegree) << i;
    EXPECT_LT(m.fit->sigma_left(i), 0.3 * kDegree);
  }
  EXPECT_TRUE(m.fit->axes.isIdentity());
  EXPECT_GT(m.correlation, 0.95);
  EXPECT_TRUE(said_of(m).empty());
}

TEST(AttitudeMatch, NamesADelay) {
  const AttitudeMatch m = match(carried_imu(), later(0.0155));
  expect_fit(m, -0.0155);
  const auto said = said_of(m);
  ASSERT_EQ(said.size(), 1u);
  EXPECT_EQ(said[0].fault, LogFault::kAttitudeClock);
  EXPECT_TRUE(contains(said[0].what, "ms late"));
  EXPECT_NEAR(attitude_delay(*m.fit, 0), 0.0155, 1e-3);
  EXPECT_TRUE(contains(attitude_delay_text(*m.fit, 0), "delay: 0.01"));
}

// An attitude on the IMU's own clock, which is ahead of GPS time, is as late as that clock is ahead; one in GPS time is
// not.
TEST(AttitudeMatch, ADelayIsAgainstGpsTime) {
  constexpr double kAhead = 12.3;  // s
  const AttitudeMatch own = match(carried_imu(), carried_attitude());
  ASSERT_TRUE(own.fit);
  EXPECT_FALSE(own.is_late());
  EXPECT_TRUE(own.is_late(kAhead));
  EXPECT_NEAR(attitude_delay(*own.fit, kAhead), kAhead, 1e-3);
  const AttitudeMatch gps = match(carried_imu(), later(-kAhead));
  ASSERT_TRUE(gps.fit);
  EXPECT_TRUE(gps.is_late());
  EXPECT_FALSE(gps.is_late(kAhead));
}

TEST(AttitudeMatch, ClocksNeedNotOverlap) {
  const double by = -2.3 * 86400;
  const AttitudeMatch m = match(carried_imu(), later(by));
  EXPECT_EQ(m.overlap, 0);
  expect_fit(m, -by);
  const auto said = said_of(m);
  ASSERT_EQ(said.size(), 1u);
  EXPECT_EQ(said[0].fault, LogFault::kNoOverlap);
  EXPECT_TRUE(contains(said[0].what, "2.30 days"));
}

TEST(AttitudeMatch, NamesTurnedAxes) {
  struct Case {
    Vector3d angles;
    std::string axes, words;
  };
  for (const Case& c :
       {Case{{0, 0, 90}, "+y -x +z", "by 90 deg about down"}, Case{{0, 0, 180}, "-x -y +z", "by 180 deg about down"},
        Case{{90, 0, 0}, "+x +z -y", "by 90 deg about forward"}}) {
    const AttitudeMatch m = match(carried_imu(), turned(from_euler(kDegree * c.angles)));
    expect_fit(m, 0);
    EXPECT_EQ(axes_text(m.fit->axes), c.axes);
    const auto said = said_of(m);
    ASSERT_EQ(said.size(), 1u);
    EXPECT_EQ(said[0].fault, LogFault::kAttitudeAxes);
    EXPECT_TRUE(contains(said[0].what, c.words)) << said[0].what;
    EXPECT_TRUE(suspicions(m, m.fit->axes, "imu", "attitude").empty());  // where the IMU is known to be mounted so
  }
}

TEST(AttitudeMatch, SaysWhyNot) {
  ImuRecording still = carried_imu();
  AttitudeRecording level = carried_attitude();
  for (Vector3d& w : still.gyro) w *= 1e-4;
  for (EulerFix& fix : level.fixes) fix.angles *= 1e-4;
  EXPECT_TRUE(contains(match(still, level).why_not, "not determined by the motion"));

  ImuRecording degrees = carried_imu();
  for (Vector3d& w : degrees.gyro) w *= kDegreesPerRadian;
  const AttitudeMatch faster = match(degrees, carried_attitude());
  EXPECT_TRUE(contains(faster.why_not, "times as fast")) << faster.why_not;
  EXPECT_TRUE(faster.contradicts);

  AttitudeRecording frozen = carried_attitude();
  for (EulerFix& fix : frozen.fixes) fix.angles *= 0.01;
  EXPECT_TRUE(match(carried_imu(), frozen).contradicts);

  ImuRecording mirrored = carried_imu();
  for (Vector3d& w : mirrored.gyro) w.y() *= -1;
  const AttitudeMatch m = match(mirrored, carried_attitude());
  EXPECT_TRUE(contains(m.why_not, "left-handed")) << m.why_not;
  EXPECT_FALSE(m.contradicts);

  AttitudeRecording few = carried_attitude();
  few.fixes.resize(20);
  EXPECT_TRUE(contains(match(carried_imu(), few).why_not, "too few"));

  AttitudeRecording other = carried_attitude();  // the same run backwards
  for (std::size_t i = 0; i < other.fixes.size(); ++i)
    other.fixes[i].angles = carried_attitude().fixes[other.fixes.size() - 1 - i].angles;
  EXPECT_FALSE(match(carried_imu(), other).fit);
}

}  // namespace
}  // namespace piste::test
