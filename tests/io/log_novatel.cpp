// Positions, velocities and raw increments in the ASCII logs of NovAtel.

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>

#include "piste/configuration/replay_config.h"
#include "piste/io/log_io.h"
#include "piste/math/earth.h"
#include "piste/math/units.h"
#include "support/receiver_logs.h"
#include "support/text_file.h"

namespace piste {
namespace {

using test::contains;
using test::message_of;
using test::novatel;

LogFile novatel_file(const std::string& text) {
  LogFile log{.file = "log", .format = LogFormat::kNovatel, .content = text};
  log.sigma_velocity = Vector3d(0.1, 0.1, 0.2);
  return log;
}
GnssRecording fixes_of(const std::string& text) { return read_gnss(novatel_file(text)); }
ImuRecording counts_of(const std::string& text) { return read_imu(novatel_file(text)); }
std::string fixes_refused(const std::string& text) {
  return message_of<DataError>([&] { fixes_of(text); });
}
std::string counts_refused(const std::string& text) {
  return message_of<DataError>([&] { counts_of(text); });
}

std::string head(const std::string& name, const std::string& time) {
  return fmt::format("#{},COM1,0,60.0,FINESTEERING,{},02000020,5b35,16809;", name, time);
}
std::string position(const std::string& time, const std::string& type = "NARROW_INT",
                     const std::string& status = "SOL_COMPUTED", const std::string& name = "BESTPOSA",
                     const std::string& datum = "WGS84") {
  return novatel(head(name, time) + status + "," + type + ",46.5,7.25,1550.25,49.75," + datum +
                 ",0.02,0.03,0.05,\"131\",1.000,0.000,22,22,22,18,00,10,7f,33");
}
std::string velocity(const std::string& time, double latency = 0, const std::string& name = "BESTVELA",
                     const std::string& status = "SOL_COMPUTED") {
  return novatel(head(name, time) + status +
                 fmt::format(",DOPPLER_VELOCITY,{:.3f},0.000,10.0000,30.000000,0.5000,0.0", latency));
}
std::string counts(const std::string& seconds, int type = 13, const std::string& info = "00") {
  return novatel(
      fmt::format("%RAWIMUSXA,2374,{0};{1},{2},2374,{0}0000,00000077,64000,-20,30,400,-500,600", seconds, info, type));
}

// ---- Fixes ----

// Lines of recorded logs and of manuals, with their own CRC.
TEST(NovatelFixes, PublishedLogs) {
  const auto gnss = fixes_of(
      "#BESTPOSA,USB1,0,58.5,FINESTEERING,2209,502061.000,02000020,cdba,16809;SOL_COMPUTED,PPP,51.15043706870,"
      "-114.03067882331,1097.3462,-17.0001,WGS84,0.0154,0.0139,0.0288,\"TSTR\",11.000,0.000,43,39,39,38,00,00,7f,37*"
      "52483ac5\r\n"
      "#BESTVELA,USB1,0,57.5,FINESTEERING,2209,502223.000,02000020,10a2,16809;SOL_COMPUTED,PPP,0.250,13.000,0.0025,"
      "28.358727,0.0021,0*e9418656\r\n");
  ASSERT_EQ(gnss.fixes.size(), 1U);
  EXPECT_EQ(gnss.fixes[0].time, 502061);
  EXPECT_EQ(gnss.fixes[0].quality, FixQuality::kPrecise);
  EXPECT_EQ(gnss.fixes[0].satellites, 39) << "of 43 tracked";
  EXPECT_NEAR(gnss.fixes[0].position.latitude, 51.15043706870 * kDegree, 1e-12);
  EXPECT_NEAR(gnss.fixes[0].position.longitude, -114.03067882331 * kDegree, 1e-12);
  EXPECT_NEAR(gnss.fixes[0].position.height, 1097.3462 - 17.0001, 1e-9) << "above the ellipsoid";
  EXPECT_EQ(gnss.fixes[0].sigma_position, Vector3d(0.0154, 0.0139, 0.0288));
  EXPECT_FALSE(gnss.fixes[0].velocity) << "that is of another time";
}

TEST(NovatelFixes, PositionAndVelocityOfOneTimeInEitherOrder) {
  const auto gnss = fixes_of(position("2374,604799.8") + velocity("2374,604799.8") + velocity("2375,0.0") +
                             position("2375,0.0") + position("2375,0.2"));
  ASSERT_EQ(gnss.fixes.size(), 3U);
  EXPECT_EQ(gnss.fixes[1].time, 604800) << "over the week's end";
  EXPECT_EQ(gnss.fixes[0].position.height, 1600);
  EXPECT_EQ(gnss.fixes[0].quality, FixQuality::kFixed);
  for (const int i : {0, 1}) {
    ASSERT_TRUE(gnss.fixes[static_cast<std::size_t>(i)].velocity);
    const FixVelocity& v = *gnss.fixes[static_cast<std::size_t>(i)].velocity;
    EXPECT_TRUE(v.value.isApprox(Vector3d(10 * std::cos(30 * kDegree), 5, -0.5)));
    EXPECT_EQ(v.sigma, Vector3d(0.1, 0.1, 0.2));
  }
  EXPECT_FALSE(gnss.fixes[2].velocity);
}

TEST(NovatelFixes, VelocitiesNeedAStatedSigma) {
  const std::string text = position("2374,1.0") + velocity("2374,1.0");
  LogFile log = novatel_file(text);
  log.sigma_velocity.reset();
  EXPECT_FALSE(read_gnss(log).fixes.at(0).velocity);
}

// One delay is estimated of a receiver: the usual latency is told, and velocities of another are left out.
TEST(NovatelFixes, TheirLatency) {
  const auto gnss = fixes_of(position("2374,1.0") + velocity("2374,1.0", 0.25) + position("2374,2.0") +
                             velocity("2374,2.0", 0.15) + position("2374,3.0") + velocity("2374,3.0", 0.15));
  EXPECT_EQ(gnss.velocity_latency, 0.15);
  EXPECT_FALSE(gnss.fixes.at(0).velocity);
  EXPECT_TRUE(gnss.fixes.at(1).velocity);
}

TEST(NovatelFixes, ALatencyMustBeStated) {
  const test::TemporaryFolder folder;
  folder.write("sensor.yaml",
               "name: x\n"
               "gyro: {noise: 0.05 deg/s/sqrt(Hz), bias: 0.5 deg/s, drift: {process: none}, scale: 0 ppm, range: 300 "
               "deg/s}\n"
               "accel: {noise: 200 ug/sqrt(Hz), bias: 0.05 m/s^2, drift: {process: none}, scale: 0 ppm, range: 2 g}\n");
  std::string text;
  for (int i = 1; i < 4; ++i) {
    text += counts(fmt::format("{}.000", i)) + counts(fmt::format("{}.010", i)) + counts(fmt::format("{}.020", i)) +
            position(fmt::format("2374,{}.5", i)) + velocity(fmt::format("2374,{}.5", i), 0.15);
  }
  folder.write("span.asc", text);
  const auto read = [&](const std::string& more) {
    const std::string config =
        "imu: {file: span.asc, sensor: sensor.yaml, format: novatel}\ngnss: {file: span.asc, format: novatel, "
        "sigma_velocity: 0.1 m/s, " +
        more + "}\n";
    return read_recording(read_replay_config(Config::parse(config, folder / "run.yaml")));
  };
  EXPECT_TRUE(contains(message_of<DataError>([&] { read("use: position velocity"); }),
                       "its velocities come 0.15 s late; state it: `velocity_delay: 0.15 s`"));
  EXPECT_EQ(read("velocity_delay: 0.15 s").gnss.at(0).fixes.size(), 3U);
  EXPECT_EQ(read("use: position").gnss.at(0).fixes.size(), 3U);
}

TEST(NovatelFixes, OneSolutionIsReadAndThatOfGnssAloneFirst) {
  const auto gnss =
      fixes_of(position("2374,1.0", "INS_RTKFIXED") + position("2374,1.0", "L1_FLOAT", "SOL_COMPUTED", "BESTGNSSPOSA") +
               velocity("2374,1.0", 0, "BESTGNSSVELA") + position("2374,1.0", "SINGLE", "SOL_COMPUTED", "PSRPOSA"));
  ASSERT_EQ(gnss.fixes.size(), 1U);
  EXPECT_EQ(gnss.fixes[0].quality, FixQuality::kFloat);
  EXPECT_TRUE(gnss.fixes[0].velocity);
}

TEST(NovatelFixes, WhatIsNotComputedIsCounted) {
  const auto gnss =
      fixes_of(position("2374,1.0", "NONE", "INSUFFICIENT_OBS") + position("2374,2.0", "PROPAGATED") +
               velocity("2374,3.0", 0, "BESTVELA", "INSUFFICIENT_OBS") + position("2374,3.0") + test::nmea("GPTXT,01"));
  EXPECT_EQ(gnss.fixes.size(), 1U);
  EXPECT_FALSE(gnss.fixes[0].velocity);
  EXPECT_EQ(gnss.without_fix, 2U);
}

TEST(NovatelFixes, Refusals) {
  const std::string good = position("2374,1.0");
  const std::pair<std::string, const char*> cases[] = {
      {good + "hello\n", "log:2: no ASCII log of NovAtel"},
      {good + position("2374,2.0").replace(70, 1, "9"), "log:2: the CRC is missing or wrong"},
      {good + good, "log:2: time 1.000000 s does not increase"},
      {good + position("2374,2.0", "INS_RTKFIXED"), "log:2: INS_RTKFIXED is a solution of the receiver's own filter"},
      {good + position("2374,2.0", "SINGLE", "SOL_COMPUTED", "BESTPOSA", "NAD83"), "log:2: the datum is NAD83"},
      {good + novatel(head("BESTPOSA", "2374,2.0") + "SOL_COMPUTED,SINGLE"), "log:2: 2 fields in BESTPOSA; 21"},
      {good + novatel(head("BESTVELA", "2374,2.0") + "SOL_COMPUTED,SINGLE"), "log:2: 2 fields in BESTVELA; 8"},
      {good + position("2374,700000"), "is no GPS week"},
      {position("2374,1.0", "NONE", "COLD_START"), "holds no fix; logs BESTGNSSPOSA"},
      {test::novatel("#RANGEA,COM1;1"), "holds no fix"},
  };
  for (const auto& [text, expected] : cases) EXPECT_TRUE(contains(fixes_refused(text), expected)) << text;
}

// ---- Increments ----

// Recorded lines of three IMUs at rest: gravity shows that the scale is right, and the axes that z, -y and x are told
// apart.
TEST(NovatelImu, PublishedLogs) {
  struct Line {
    std::string text;
    double rate, turn;  // Hz; rad that one count of the gyroscopes stands for
    Vector3d counts;    // x, y, z of the gyroscopes
  };
  const double kArcsecond = kDegree / 3600;
  const Line lines[] = {
      {"%RAWIMUSXA,1692,484620.664;00,11,1692,484620.664389000,00801503,43110635,-817242,-202184,-215194,-41188,-9895*"
       "a5db8c7b\n",
       100,
       std::pow(2, -33),
       {-9895, 41188, -215194}},
      {"%RAWIMUSXA,2209,491674.014;04,41,2209,491674.013699,ea59fe00,329308016,-2706935,4508389,196192,417138,"
       "-1000837*038422a7\n",
       125,
       0.008 / 65536 / 125 * kDegree,
       {-1000837, -417138, 196192}},
      {"%RAWIMUSXA,2075,507495.165;00,13,2075,507495.165000000,00000000,32068,-1612,-1320,256,1536,-255*dd88585c\n",
       200,
       0.1 / 256 * kArcsecond,
       {-255, -1536, 256}},
  };
  for (const Line& line : lines) {
    RowFaults faults;
    const ImuRecording imu = read_imu(novatel_file(line.text), &faults);
    ASSERT_EQ(imu.time.size(), 1U) << line.text;
    EXPECT_EQ(faults.total(), 0U);
    EXPECT_TRUE(imu.increments);
    EXPECT_NEAR(line.rate * imu.accel[0].z(), 9.81, 0.06) << line.text;
    EXPECT_TRUE(imu.gyro[0].isApprox(line.turn * line.counts)) << line.text;
  }
}

TEST(NovatelImu, AxesAndTimes) {
  const ImuRecording imu = counts_of(counts("1.000") + position("2374,1.0") + counts("1.010") + counts("1.020"));
  ASSERT_EQ(imu.time.size(), 3U);
  EXPECT_DOUBLE_EQ(imu.time[1], 1.01);
  EXPECT_TRUE(imu.accel[1].isApprox(0.05 / 32768 * Vector3d(30, 20, 64000)));
  EXPECT_TRUE(imu.gyro[1].isApprox(0.1 / 256 / 3600 * kDegree * Vector3d(600, 500, 400)));
}

TEST(NovatelImu, Refusals) {
  const std::string good = counts("1.000") + counts("1.010");
  const std::pair<std::string, const char*> cases[] = {
      {good + counts("1.020", 99), "log:3: what a count of the IMU of type 99 stands for is not known"},
      {good + counts("1.020", 26), "log:3: the IMU is of type 26, and of 13 above"},
      {good + counts("1.020", 13, "01"), "log:3: the IMU marks the row as not valid (info 01)"},
      {good + counts("1.020", 13, "06"), "log:3: the IMU marks the row as not valid (info 06)"},
      {good + counts("1.020", 13, "x4"), "log:3: `x4` is no info of an IMU"},
      {good + counts("1.010"), "log:3: time 1.010000 s does not increase"},
      {good + novatel("%RAWIMUSXA,2374,2.0;00,13,2374"), "log:3: 3 fields in RAWIMUSXA; 11 are expected"},
      {position("2374,1.0") + novatel("%RAWIMUSA,2374,1.0;2374,1.0,00000077,64000,-20,30,400,-500,600"),
       "log:2: RAWIMUA and RAWIMUSA do not say the type of the IMU"},
      {counts("1.000") + counts("2.000"), "the median specific force is 0.09766"},
  };
  for (const auto& [text, expected] : cases) EXPECT_TRUE(contains(counts_refused(text), expected)) << text;
}

}  // namespace
}  // namespace piste
