// Text logs whose columns have names of their own.

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "piste/configuration/replay_config.h"
#include "piste/io/config.h"
#include "piste/io/log_io.h"
#include "piste/math/earth.h"
#include "support/text_file.h"

namespace piste {
namespace {

using test::contains;
using test::message_of;
using test::TemporaryFolder;

const std::string kSensorOfColumns =
    "name: x\n"
    "gyro: {noise: 0.05 deg/s/sqrt(Hz), bias: 0.5 deg/s, drift: {process: none}, scale: 0 ppm, range: 300 deg/s}\n"
    "accel: {noise: 200 ug/sqrt(Hz), bias: 0.05 m/s^2, drift: {process: none}, scale: 0 ppm, range: 2 g}\n";
const std::string kPlace =
    "latitude: {name: lat, unit: deg}, longitude: {name: lon, unit: deg}, height: {name: h, unit: m}";

struct Columns : ::testing::Test {
  TemporaryFolder folder;

  Recording read(const std::string& imu, const std::string& gnss, const std::string& more = "") const {
    folder.write("sensor.yaml", kSensorOfColumns);
    const std::string text = "imu: {file: imu.txt, sensor: sensor.yaml, format: columns, " + imu +
                             "}\ngnss: {file: gnss.txt, format: columns, " + gnss + "}\n" + more;
    return read_recording(read_replay_config(Config::parse(text, folder / "run.yaml")));
  }
  ImuRecording imu(const std::string& text, const std::string& keys) const {
    folder.write("imu.txt", text);
    folder.write("gnss.txt", "t lat lon h\n1 46 7 100\n2 46 7 100\n");
    return read(keys, "sigma: 1 1 1 m, columns: {time: {name: t, unit: s}, " + kPlace + "}").imu;
  }
  GnssRecording gnss(const std::string& text, const std::string& keys) const {
    folder.write("gnss.txt", text);
    folder.write("imu.txt", "t gx gy gz ax ay az\n1 0 0 0 0 0 1\n2 0 0 0 0 0 1\n");
    return read(
               "columns: {time: {name: t, unit: s}, gyro: {names: [gx, gy, gz], unit: deg/s}, accel: {names: [ax, ay, "
               "az], unit: g}}",
               keys)
        .gnss.at(0);
  }
  template <class F>
  std::string refused(F&& read_it) const {
    try {
      read_it();
    } catch (const Error& e) {
      return e.what();
    }
    return {};
  }
};

const std::string kNamed = "columns: {time: {name: t}, gyro: {names: [gx, gy, gz]}, accel: {names: [ax, ay, az]}}";
const std::string kNamedHeader = "t [ms];gx [deg/s];gy [deg/s];gz [deg/s];ax [g];ay [g];az [g];note\n";

// ---- Layout, names and units ----

TEST_F(Columns, HeaderBelowOtherLinesWithUnitsAndATrailingDelimiter) {
  const auto log =
      imu("Sensor: LSM6DSL\nVendor: STM\n" + kNamedHeader + "10;90;0;-90;0;0;1;x;\n20;0;0;0;0;0;1;;\n", kNamed);
  ASSERT_EQ(log.time, (std::vector<double>{0.010, 0.020}));
  EXPECT_NEAR(log.gyro[0].x(), std::numbers::pi / 2, 1e-12);
  EXPECT_NEAR(log.gyro[0].z(), -std::numbers::pi / 2, 1e-12);
  EXPECT_NEAR(log.accel[1].z(), kStandardGravity, 1e-12);
  EXPECT_FALSE(log.increments);
}

TEST_F(Columns, NumbersNameTheColumnsWithoutAHeader) {
  const std::string keys =
      "columns: {time: {name: 7, unit: ms}, gyro: {names: [4, 5, 6], unit: deg/s}, accel: {names: [1, 2, 3], unit: g}}";
  const auto log = imu("0.1,0,1,1,2,3,261906\n0.1,0,1,4,5,6,261916\n", keys);
  EXPECT_EQ(log.time, (std::vector<double>{261.906, 261.916}));
  EXPECT_NEAR(log.gyro[1].z(), 6 * kDegree, 1e-12);
  EXPECT_NEAR(log.accel[0].x(), 0.1 * kStandardGravity, 1e-12);
  EXPECT_TRUE(contains(refused([&] { imu("0,0,1,1,2,3\n0,0,1,4,5,6\n", keys); }),
                       "imu.txt:1: there is no column `7` of `time`: the file has no header, and its columns have the "
                       "numbers 1 to 6"));
}

TEST_F(Columns, LayoutAsStated) {
  const std::string keys = kNamed.substr(0, kNamed.size() - 1) + "}, skip: 1, delimiter: tab";
  const std::string header = "t [s]\tgx [rad/s]\tgy [rad/s]\tgz [rad/s]\tax [m/s²]\tay [m/s²]\taz [m/s²]\n";
  const auto log = imu("1\t2\t3\t4\t5\t6\t7\n" + header + "1\t0\t0\t0\t0\t0\t9.8\n2\t0\t0\t0\t0\t0\t9.8\n", keys);
  EXPECT_EQ(log.time, (std::vector<double>{1, 2}));
  EXPECT_EQ(log.accel[0].z(), 9.8);
}

TEST_F(Columns, EurocStyle) {
  const std::string header =
      "#timestamp [ns],w_RS_S_x [rad s^-1],w_RS_S_y [rad s^-1],w_RS_S_z [rad s^-1],a_RS_S_x [m s^-2],a_RS_S_y [m "
      "s^-2],a_RS_S_z [m s^-2]\n";
  const auto log = imu(header + "1403636579758555392,-0.1,0.2,0.3,8.1,-0.3,-3.1\n1403636579763555584,0,0,0,9,0,-3\n",
                       "columns: {time: {name: timestamp, of: unix}, gyro: {names: [w_RS_S_x, w_RS_S_y, w_RS_S_z]}, "
                       "accel: {names: [a_RS_S_x, a_RS_S_y, a_RS_S_z]}}");
  EXPECT_EQ(log.gyro[0], Vector3d(-0.1, 0.2, 0.3));
  // 2014-06-24 19:02:59.758555392 UTC is a Tuesday, 16 s behind GPS time. All digits are kept.
  EXPECT_NEAR(log.time[0], 2 * 86400 + 19 * 3600 + 2 * 60 + 59 + 16 + 0.758555392, 1e-9);
  EXPECT_NEAR(log.time[1] - log.time[0], 0.005000192, 1e-10);
}

TEST_F(Columns, TimesOfEveryKind) {
  const auto first = [&](const std::string& cell, const std::string& time) {
    const std::string row = ",0,0,0,0,0,9.8\n";
    return imu("t,w,gx,gy,gz,ax,ay,az\n" + cell + row + cell + row,
               "repair: true, columns: {time: " + time +
                   ", gyro: {names: [gx, gy, gz], unit: rad/s}, accel: {names: [ax, ay, az], unit: m/s^2}}");
  };
  const auto time = [&](const std::string& cell, const std::string& how) {
    folder.write("imu.txt", "");
    const std::string row = ",0,0,0,0,0,9.8\n";
    const std::string later = cell.substr(0, cell.find(',')) + "5" + cell.substr(cell.find(','));
    return imu("t,w,gx,gy,gz,ax,ay,az\n" + cell + row + later + row,
               "columns: {time: " + how +
                   ", gyro: {names: [gx, gy, gz], unit: rad/s}, accel: {names: [ax, ay, az], unit: m/s^2}}")
        .time.at(0);
  };
  EXPECT_EQ(time("473995.2,0", "{name: t, unit: s}"), 473995.2);
  EXPECT_EQ(time("473995.2,2130", "{name: t, unit: s, of: gps_week, week: w}"), 473995.2);
  EXPECT_EQ(time("473995.2,0", "{name: t, unit: s, of: gps_week}"), 473995.2);
  const double instant = 3 * 86400 + 8 * 3600 + 17 * 60 + 31.4;  // a Wednesday
  EXPECT_NEAR(time("1604477851.4,0", "{name: t, unit: s, of: unix}"), instant + 18, 1e-6);
  EXPECT_NEAR(time("1288513069.4,0", "{name: t, unit: s, of: gps}"), instant + 18, 1e-6);
  EXPECT_NEAR(time("2020-11-04 08:17:31.4,0", "{name: t, unit: calendar, of: utc}"), instant + 18, 1e-9);
  EXPECT_NEAR(time("2020-11-04T08:17:31.4,0", "{name: t, unit: calendar, of: gps}"), instant, 1e-9);
  EXPECT_NEAR(time("08:17:31.4,20201104", "{name: t, date: w, unit: calendar, of: utc}"), instant + 18, 1e-9);
  EXPECT_NEAR(time("4.11.2020 8:17:31.4,0", "{name: t, unit: calendar, of: gps}"), instant, 1e-9);
  EXPECT_NEAR(time("20201104T081731.4,0", "{name: t, unit: calendar, of: gps}"), instant, 1e-9);
  EXPECT_NEAR(time("81731.4,0", "{name: t, unit: hhmmss}"), 8 * 3600 + 17 * 60 + 31.4, 1e-9);
  EXPECT_NEAR(time("08:17:31.4,0", "{name: t, unit: hhmmss}"), 8 * 3600 + 17 * 60 + 31.4, 1e-9);
  EXPECT_TRUE(contains(refused([&] { first("86100.5,0", "{name: t, unit: hhmmss}"); }), "is no time of day"));
  EXPECT_TRUE(contains(refused([&] { first("1,0", "{name: t, unit: hhmmss, of: utc}"); }), "`of: boot`"));
  EXPECT_TRUE(
      contains(refused([&] { first("12.5,0", "{name: t, unit: s, of: unix}"); }), "`of: boot` is time since power-up"));
  EXPECT_TRUE(contains(refused([&] { first("noon 1:2:3,0", "{name: t, unit: calendar, of: utc}"); }),
                       "is no time; right would be"));
}

TEST_F(Columns, CountersGoOnPastTheirEnd) {
  const auto times = [&](const std::string& unit, const std::vector<std::string>& counts) {
    std::string text = "t,gx,gy,gz,ax,ay,az\n";
    for (const std::string& count : counts) text += count + ",0,0,0,0,0,9.8\n";
    return imu(text, "columns: {time: {name: t, unit: " + unit +
                         "}, gyro: {names: [gx, gy, gz], unit: rad/s}, accel: {names: [ax, ay, az], unit: m/s^2}}")
        .time;
  };
  const auto shorter = times("ms", {"65520", "65530", "4", "14"});
  EXPECT_NEAR(shorter[2], 65.540, 1e-9);
  EXPECT_NEAR(shorter[3], 65.550, 1e-9);
  EXPECT_NEAR(times("us", {"4294960000", "2704"})[1], 4294.970, 1e-9);
  EXPECT_TRUE(contains(refused([&] { times("ms", {"65520", "60000"}); }), "does not increase"));
}

TEST_F(Columns, TimesInTwoColumnsAreAddedUp) {
  const std::string row = ",0,0,0,0,0,9.8\n";
  const auto with = [&](const std::string& rows, const std::string& time) {
    return imu("t,n,gx,gy,gz,ax,ay,az\n" + rows,
               "columns: {time: " + time +
                   ", gyro: {names: [gx, gy, gz], unit: rad/s}, accel: {names: [ax, ay, az], unit: m/s^2}}");
  };
  const std::string rows = "1604477851,400000000" + row + "1604477852,5" + row;
  const auto absolute = with(rows, "{name: t, unit: s, of: unix, rest: {name: n, unit: ns}}");
  EXPECT_NEAR(absolute.time[0], 3 * 86400 + 8 * 3600 + 17 * 60 + 31.4 + 18, 1e-9);
  EXPECT_NEAR(absolute.time[1] - absolute.time[0], 0.600000005, 1e-10);
  EXPECT_NEAR(with("7,250" + row + "8,0" + row, "{name: t, unit: s, rest: {name: n, unit: ms}}").time[0], 7.25, 1e-12);
  EXPECT_TRUE(contains(refused([&] { with(rows, "{name: t, unit: calendar, of: utc, rest: {name: n, unit: ns}}"); }),
                       "goes with a number"));
}

TEST_F(Columns, CommasAreDecimalSignsWhereTheySeparateNothing) {
  const auto log =
      imu("t [s];gx [deg/s];gy [deg/s];gz [deg/s];ax [g];ay [g];az [g]\n1,25;1,5;0;-0,5;0;0;1,0\n1,5;0;0;0;0;0;1\n",
          kNamed);
  EXPECT_EQ(log.time, (std::vector<double>{1.25, 1.5}));
  EXPECT_NEAR(log.gyro[0].x(), 1.5 * kDegree, 1e-12);
  EXPECT_NEAR(log.gyro[0].z(), -0.5 * kDegree, 1e-12);
  EXPECT_TRUE(contains(refused([&] { imu(kNamedHeader + "10;1,2,3;0;0;0;0;1;\n20;0;0;0;0;0;1;\n", kNamed); }),
                       "`1,2,3`, is no number"));
}

// As a logger writes it that makes a row of each sample of its fastest sensor.
TEST_F(Columns, RowsThatRepeatThePlaceArePassedOver) {
  const std::string keys = "sigma: 1 1 1 m, columns: {time: {name: t, unit: s}, " + kPlace;
  const std::string header = "t,lat,lon,h,gx\n", without = "1,,,,0\n",
                    rows = "2,46,7,100,0\n3,46,7,100,0\n4,46,7.1,100,0\n5,46,7.1,100,0\n6,46,7,100,0\n";
  const GnssRecording read = gnss(header + without + rows, keys + ", only_new: true}");
  ASSERT_EQ(read.fixes.size(), 3U);
  EXPECT_EQ(read.fixes[1].time, 4);
  EXPECT_EQ(read.without_fix, 0U) << "the receiver said nothing there";
  EXPECT_EQ(gnss(header + rows, keys + "}").fixes.size(), 5U);
}

TEST_F(Columns, RowsOfOneSensorAmongOthers) {
  const auto keys = [](const std::string& kind, const std::string& time, const std::string& xyz) {
    return fmt::format(
        "accel_file: imu.txt, columns: {{time: {{name: {1}, unit: s}}, rows: {{name: {0}, is: gyro}}, gyro: {{names: "
        "[{2}], unit: deg/s}}, accel: {{names: [{2}], unit: g, rows: {{name: {0}, is: acc}}}}}}",
        kind, time, xyz);
  };
  const std::string header = "kind,t,x,y,z\n", named = keys("kind", "t", "x, y, z"),
                    numbered = keys("1", "2", "3, 4, 5");
  std::string rows;
  for (int i = 0; i < 5; ++i) rows += fmt::format("gyro,{0},3,0,0\nacc,{0},0,0,1\nmag,{0},20,5,-40\n", i);
  // By its number: rows of others may have any number of fields.
  for (const ImuRecording& read :
       {imu(header + rows, named), imu("# a comment\n" + rows + "baro,4,1013\n", numbered)}) {
    ASSERT_EQ(read.time.size(), 4U) << "the first interval is not known";
    EXPECT_NEAR(read.gyro[1].x(), 3 * kDegree, 1e-12);
    EXPECT_NEAR(read.accel[1].z(), kStandardGravity, 1e-12);
  }
  EXPECT_TRUE(contains(refused([&] { imu(header + "mag,1,20,5,-40\nmag,2,20,5,-40\n", named); }),
                       "no row has `gyro` in column `kind`, as `rows` has it"));
  EXPECT_TRUE(contains(refused([&] { imu("mag,1,20,5,-40\nmag,2,20,5,-40\n", numbered); }),
                       "no rows of numbers with `gyro` in column `1`"));
}

// A table that is merged from several logs: what is empty in all columns is of another sensor, and what is empty in one
// is a fault.
TEST_F(Columns, RowsWithoutAnyValueAreOfAnother) {
  const std::string keys =
      "columns: {time: {name: t, unit: s}, gyro: {names: [gx, gy, gz], unit: deg/s}, accel: "
      "{names: [ax, ay, az], unit: g}}";
  const std::string header = "t,gx,gy,gz,ax,ay,az,lat\n",
                    rows = "1,0,0,0,0,0,1,\n2,,,,,,,46\n3,0,0,0,0,0,1,\n4,nan,nan,nan,nan,nan,nan,46\n";
  EXPECT_EQ(imu(header + rows, keys).time, (std::vector<double>{1, 3}));
  EXPECT_TRUE(contains(refused([&] { imu(header + rows + "5,0,0,,0,0,1,\n", keys); }), "imu.txt:6"));
}

// Of a table in which one sensor is slower, and of a logger that writes zeros before the first sample.
TEST_F(Columns, RowsWithoutATriadArePassedOverAndCounted) {
  const std::string keys =
      "columns: {time: {name: t, unit: s}, gyro: {names: [gx, gy, gz], unit: deg/s}, accel: "
      "{names: [ax, ay, az], unit: g}}";
  const ImuRecording read =
      imu("t,gx,gy,gz,ax,ay,az\n0,0,0,0,0,0,0\n1,0,0,0,0,0,1\n2,,,,0,0,1\n3,1,0,0,,,\n4,0,0,0,0,0,1\n", keys);
  EXPECT_EQ(read.time, (std::vector<double>{1, 4}));
  EXPECT_EQ(read.unpaired, 3U);
}

// Sentences arrive one after another: place in one row, speed in the next, height in the one after.
TEST_F(Columns, WhatChangesARowLaterBelongsToThePlace) {
  std::string rows = "t,lat,lon,h,v,c\n";
  for (int fix = 0, row = 0; fix < 20; ++fix) {
    for (int k = 0; k < 6; ++k, ++row) {
      rows += fmt::format("{:.2f},46.{:04},7,{},{},0\n", 0.02 * row, 100 + fix, 300 + (k < 2 ? fix - 1 : fix),
                          k < 1 ? fix - 1 : fix);
    }
  }
  const GnssRecording read =
      gnss(rows, "sigma: 1 1 1 m, sigma_velocity: 0.1 m/s, columns: {time: {name: t, unit: s}, " + kPlace +
                     ", speed: {name: v, unit: m/s}, course: {name: c, unit: deg}, only_new: true}");
  ASSERT_EQ(read.fixes.size(), 20U);
  for (int fix = 1; fix < 20; ++fix) {
    const GeodeticFix& found = read.fixes[static_cast<std::size_t>(fix)];
    EXPECT_NEAR(found.time, 0.12 * fix, 1e-9);
    EXPECT_EQ(found.position.height, 300 + fix);
    EXPECT_NEAR(found.velocity->value.x(), fix, 1e-9);
  }
}

// A parser that sets the latitude in one row and the longitude in the next: one fix, and not two of half a place.
TEST_F(Columns, TheOtherHalfOfAPlaceIsNoNewFix) {
  const auto read = [&](int apart) {
    std::string rows = "t,lat,lon,h\n0.00,0,0,0\n0.02,0,0,0\n";
    for (int fix = 0, row = 2; fix < 20; ++fix) {
      for (int k = 0; k < 10; ++k, ++row) {
        const int before = fix > 0 ? 200 + fix - 1 : 0;
        rows += fmt::format("{:.2f},46.{:04},{}.{:04},300\n", 0.02 * row, 100 + fix, k < apart && fix == 0 ? 0 : 7,
                            k < apart ? before : 200 + fix);
      }
    }
    return gnss(rows, "sigma: 1 1 1 m, columns: {time: {name: t, unit: s}, " + kPlace + ", only_new: true}");
  };
  for (const int apart : {0, 1, 3}) {
    const GnssRecording found = read(apart);
    ASSERT_EQ(found.fixes.size(), 20U) << apart;
    for (int fix = 0; fix < 20; ++fix) {
      const GeodeticFix& at = found.fixes[static_cast<std::size_t>(fix)];
      EXPECT_NEAR(at.time, 0.04 + 0.2 * fix, 1e-9);
      EXPECT_NEAR(at.position.longitude / kDegree, 7.02 + 1e-4 * fix, 1e-9) << apart;
    }
  }
}

TEST_F(Columns, QualitiesOfFixes) {
  const auto read = [&](const std::string& of, const std::array<std::string, 4>& values, const std::string& more) {
    std::string rows = "t,lat,lon,h,Q\n";
    for (std::size_t i = 0; i < values.size(); ++i) rows += fmt::format("{},46.{},7,1,{}\n", i, i, values[i]);
    return gnss(rows, "sigma: 1 1 1 m, " + more + "columns: {time: {name: t, unit: s}, " + kPlace +
                          ", quality: {name: Q" + of + "}}");
  };
  using enum FixQuality;
  for (const auto& [of, values] : {std::pair{", of: nmea", std::array<std::string, 4>{"4", "5", "0", "1"}},
                                   std::pair{", of: rtklib", std::array<std::string, 4>{"1", "2", "9", "5"}},
                                   std::pair{"", std::array<std::string, 4>{"RTK_FIXED", "float", "no fix", "3D"}}}) {
    const GnssRecording all = read(of, values, "");
    ASSERT_EQ(all.fixes.size(), 3U) << of;
    EXPECT_EQ(all.without_fix, 1U);
    EXPECT_EQ(all.fixes[0].quality, kFixed);
    EXPECT_EQ(all.fixes[1].quality, kFloat);
    EXPECT_EQ(all.fixes[2].quality, kSingle);
    const GnssRecording sure = read(of, values, "use_quality: [fixed, float], sigma_scale: {fixed: 0.5, float: 3}, ");
    ASSERT_EQ(sure.fixes.size(), 2U);
    EXPECT_EQ(sure.not_used, 1U);
    EXPECT_EQ(sure.fixes[0].sigma_position.x(), 0.5);
    EXPECT_EQ(sure.fixes[1].sigma_position.x(), 3);
  }
  EXPECT_TRUE(contains(refused([&] {
                         read("", {"FIX", "FIX", "FIX", "FIX"}, "use_quality: flaot, ");
                       }),
                       "there is no quality `flaot`; there are"));
}

TEST_F(Columns, TimesInDays) {
  const auto times = [&](const std::string& rows, const std::string& unit) {
    return imu("t,gx,gy,gz,ax,ay,az\n" + rows, "columns: {time: {name: t, of: utc, unit: " + unit +
                                                   "}, gyro: {names: [gx, gy, gz], unit: deg/s}, accel: {names: [ax, "
                                                   "ay, az], unit: g}}")
        .time;
  };
  // Wednesday, 7 February 2024, 12:00 UTC, and 0.864 s later.
  const std::string values = ",0,0,0,0,0,1\n";
  for (const auto& [day, unit] : {std::pair{"739289", "datenum"}, std::pair{"45329", "sheet_days"}}) {
    const auto read = times(fmt::format("{0}.50000{1}{0}.50001{1}", day, values), unit);
    EXPECT_NEAR(read.at(0), 3 * 86400 + 12 * 3600 + 18, 1e-6) << unit;
    EXPECT_NEAR(read.at(1) - read.at(0), 0.864, 1e-6) << unit;
  }
  EXPECT_TRUE(contains(refused([&] { times("12.5" + values + "12.6" + values, "datenum"); }), "is no time in days"));
}

TEST_F(Columns, ALineOfUnitsStandsBelowTheNames) {
  const std::string keys = "columns: {time: {name: t}, gyro: {names: [gx, gy, gz]}, accel: {names: [ax, ay, az]}}";
  const std::string rows = "1,3,0,0,0,0,1\n2,3,0,0,0,0,1\n";
  const ImuRecording read = imu("t,gx,gy,gz,ax,ay,az\n(s),(deg/s),(deg/s),(deg/s),(g),(g),(g)\n" + rows, keys);
  EXPECT_NEAR(read.gyro[0].x(), 3 * kDegree, 1e-12);
  EXPECT_NEAR(read.accel[0].z(), kStandardGravity, 1e-12);
  EXPECT_TRUE(contains(refused([&] { imu("t,gx,gy,gz,ax,ay,az\ns,m,m,m,g,g,g\n" + rows, keys); }),
                       "does not measure an angular rate"));
}

TEST_F(Columns, GravityMayBeAdded) {
  const ImuRecording read = imu("t,gx,gy,gz,ax,ay,az,hx,hy,hz\n1,0,0,0,.1,0,0,0,0,1\n2,0,0,0,.1,0,0,0,0,1\n",
                                "columns: {time: {name: t, unit: s}, gyro: {names: [gx, gy, gz], unit: deg/s}, accel: "
                                "{names: [ax, ay, az], added: [hx, hy, hz], unit: g, axes: +x -y -z}}");
  EXPECT_NEAR((read.accel[0] - kStandardGravity * Vector3d(0.1, 0, -1)).norm(), 0, 1e-12);
}

// Of Android: an accuracy of zero is one that is not known.
TEST_F(Columns, AnAccuracyOfZeroIsNone) {
  const std::string keys = "columns: {time: {name: t, unit: s}, " + kPlace +
                           ", horizontal_accuracy: {name: ha, unit: m}, vertical_accuracy: {name: va, unit: m}, speed: "
                           "{name: s, unit: m/s}, course: {name: c, unit: deg}, speed_accuracy: {name: sa, unit: m/s}}";
  const GnssRecording read =
      gnss("t,lat,lon,h,ha,va,s,c,sa\n1,46,7,400,0,3,1,90,0.5\n2,46,7,400,3,3,1,90,0\n3,46,7,400,3,3,1,90,0.5\n", keys);
  EXPECT_EQ(read.without_fix, 1U);
  ASSERT_EQ(read.fixes.size(), 2U);
  EXPECT_FALSE(read.fixes[0].velocity);
  EXPECT_TRUE(read.fixes[1].velocity);
}

TEST_F(Columns, DatesInEveryOrder) {
  const auto day = [&](const std::string& date, const std::string& next) {
    const std::string row = ",0,0,0,0,0,9.8\n";
    return imu("t,gx,gy,gz,ax,ay,az\n" + date + row + next + row,
               "columns: {time: {name: t, unit: calendar, of: gps}, gyro: {names: [gx, gy, gz], unit: rad/s}, accel: "
               "{names: [ax, ay, az], unit: m/s^2}}")
               .time[0] /
           86400;
  };
  const double wednesday = 3 + 0.5;  // 20 August 2025
  EXPECT_NEAR(day("20/08/2025 12:00:00", "20/08/2025 12:00:01"), wednesday, 1e-9);
  EXPECT_NEAR(day("08/20/2025 12:00:00", "08/20/2025 12:00:01"), wednesday, 1e-9);
  EXPECT_NEAR(day("20-Aug-2025 12:00:00.000", "20-AUG-2025 12:00:00.010"), wednesday, 1e-9);
  EXPECT_NEAR(day("20-OCT-2025 12:00:00.000", "20-Oct-2025T12:00:00.010"), 1 + 0.5, 1e-9);
  EXPECT_NEAR(day("2025-08-20 12:00:00:000", "2025-08-20 12:00:00:010"), wednesday, 1e-9);
  EXPECT_NEAR(day("2025-08-20T12.00.00.000", "2025-08-20T12.00.00.010"), wednesday, 1e-9);
  // The first date decides: nothing leaps from 8 December to 13 August.
  EXPECT_TRUE(contains(refused([&] { day("08/12/2025 23:59:59", "08/13/2025 00:00:00"); }), "imu.txt:3"));
}

TEST_F(Columns, CalendarTimesMayStateTheirZone) {
  const std::string row = ",0,0,0,0,0,9.8\n";
  const auto log = imu("t,gx,gy,gz,ax,ay,az\n2020-11-04 00:17:31.4 +0100" + row + "2020-11-03T18:47:31.5-04:30" + row,
                       "columns: {time: {name: t, unit: calendar, of: utc}, gyro: {names: [gx, gy, gz], unit: rad/s}, "
                       "accel: {names: [ax, ay, az], unit: m/s^2}}");
  EXPECT_NEAR(log.time[0], 2 * 86400 + 23 * 3600 + 17 * 60 + 31.4 + 18, 1e-9);
  EXPECT_NEAR(log.time[1] - log.time[0], 0.1, 1e-9);
}

TEST_F(Columns, IncrementsMagneticFieldAndTemperature) {
  const auto log =
      imu("t dx dy dz vx vy vz mx my mz T\n1 0 0 0.1 0 0 9.8 20 0 -40 21.5\n2 0 0 0.1 0 0 9.8 20 0 -40 21.5\n",
          "columns: {time: {name: t, unit: s}, dtheta: {names: [dx, dy, dz], unit: mrad}, dvel: {names: [vx, "
          "vy, vz], unit: m/s}, magnetic: {names: [mx, my, mz], unit: uT}, temperature: {name: T, unit: degC}}");
  EXPECT_TRUE(log.increments);
  EXPECT_NEAR(log.gyro[1].z(), 1e-4, 1e-15);
  EXPECT_NEAR(log.magnetic[0].z(), -40, 1e-12);
  EXPECT_EQ(log.temperature[0], 21.5);
}

TEST_F(Columns, RefusesWhatCannotBe) {
  const std::string rows = "10;0;0;0;0;0;1;\n20;0;0;0;0;0;1;\n";
  const auto with = [&](const std::string& keys) { return refused([&] { imu(kNamedHeader + rows, keys); }); };
  const std::string gyro = "gyro: {names: [gx, gy, gz]}", accel = "accel: {names: [ax, ay, az]}",
                    time = "time: {name: t}";
  EXPECT_TRUE(
      contains(with("columns: {" + time + ", gyro: {names: [gx, gyy, gz]}, " + accel + "}"),
               "imu.txt:1: there is no column `gyy` of `gyro`, perhaps `gy`; the columns are: t [ms], gx [deg/s]"));
  EXPECT_TRUE(contains(with("columns: {" + time + ", gyro: {names: [gx, gy, gz], unit: m/s}, " + accel + "}"),
                       "run.yaml:1: unit: unit `m/s` does not measure an angular rate"));
  EXPECT_TRUE(contains(with("columns: {" + time + ", gyro: {names: [ax, ay, az]}, " + accel + "}"),
                       "column `ax` of `gyro`: unit `g` does not measure an angular rate"));
  EXPECT_TRUE(
      contains(with("columns: {" + time + ", gyro: {names: [gx, gy]}, " + accel + "}"), "2 columns are named, but 3"));
  EXPECT_TRUE(contains(with("columns: {" + gyro + ", " + accel + "}"), "key `time` is missing"));
  EXPECT_TRUE(contains(with("columns: {" + time + ", " + gyro + "}"), "columns: `accel` is missing"));
  EXPECT_TRUE(contains(with("columns: {" + time + ", " + gyro + ", " + accel + ", hue: {name: note}}"), "hue"));
  EXPECT_TRUE(contains(with("skip: 0"), "columns needs the key `columns:`"));
  const auto of = [&](const std::string& text) { return refused([&] { imu(kNamedHeader + text, kNamed); }); };
  EXPECT_TRUE(contains(of(rows + "30;0;0\n"), "imu.txt:4: 3 fields, but 8 columns are named; is the line cut?"));
  EXPECT_TRUE(contains(of(rows + "30;0;0;;0;0;1;\n"), "imu.txt:4: field 4, ``, is no number"));
  EXPECT_TRUE(contains(of(rows + "30;0;0;nan;0;0;1;\n"), "imu.txt:4: field 4, `nan`, must be finite"));
  EXPECT_TRUE(contains(of(rows + "15;0;0;0;0;0;1;\n"), "does not increase"));
  EXPECT_TRUE(contains(of(rows + "15;0;0;0;0;0;1;\n"), "`repair: true`"));
  EXPECT_TRUE(contains(of(""), "imu.txt:1: no rows of numbers are found"));
  const auto unitless = refused([&] { imu("t,gx,gy,gz,ax,ay,az\n1,0,0,0,0,0,1\n2,0,0,0,0,0,1\n", kNamed); });
  EXPECT_TRUE(contains(unitless, "column `gx` of `gyro` has no unit in the header; give it in the configuration"));
}

// ---- Gyroscopes and accelerometers apart ----

struct Apart : Columns {
  // Gyroscopes each 10 ms from 1.000 s, accelerometers at `times` with a force of 9 + t along z.
  ImuRecording read_apart(const std::vector<double>& times, const std::string& keys = "") const {
    std::string gyro = "t [s],x [rad/s],y [rad/s],z [rad/s]\n", accel = "s [s],x [m/s^2],y [m/s^2],z [m/s^2]\n";
    for (int i = 0; i < 100; ++i) gyro += fmt::format("{:.3f},0,0,{:.2f}\n", 1 + 0.01 * i, 0.01 * i);
    for (const double t : times) accel += fmt::format("{:.6f},0,0,{:.9f}\n", t, 9 + t);
    folder.write("accel.txt", accel);
    return imu(gyro,
               "accel_file: accel.txt, " + keys +
                   " columns: {time: {name: t}, gyro: {names: [x, y, z]}, accel: {names: [x, y, z], time: {name: s}}}");
  }
  static std::vector<double> evenly(double from, double to, double step) {
    std::vector<double> times;
    for (double t = from; t < to; t += step) times.push_back(t);
    return times;
  }
};

TEST_F(Apart, InstantsAreOnTheLineBetweenNeighbours) {
  const auto log = read_apart(evenly(0.994, 2.1, 0.013), "sampling: instant,");
  ASSERT_EQ(log.time.size(), 100u);
  for (std::size_t i = 0; i < log.time.size(); ++i) EXPECT_NEAR(log.accel[i].z(), 9 + log.time[i], 1e-6);
  EXPECT_EQ(log.gyro[7].z(), 0.07);
}

// Gravity apart from accelerations without it, as a phone's fusion has them: rows of the same stamps are added.
TEST_F(Apart, GravityInAFileOfItsOwn) {
  const auto with = [&](const std::vector<double>& times, const std::string& more = "gravity_file: gravity.txt,",
                        const std::string& added = ", added: [x, z, y]") {
    std::string gravity = "s [s],x [m/s^2],y [m/s^2],z [m/s^2]\n", linear = gravity, gyro = gravity;
    for (const double t : times) gravity += fmt::format("{:.3f},0.25,9.75,0\n", t);
    for (int i = 0; i < 100; ++i) {
      linear += fmt::format("{0:.3f},0.5,0,{0:.3f}\n", 1 + 0.01 * i);
      gyro += fmt::format("{:.3f},0,0,0\n", 1 + 0.01 * i);
    }
    folder.write("gravity.txt", gravity);
    folder.write("accel.txt", linear);
    std::string header = "t [s],x [rad/s],y [rad/s],z [rad/s]\n";
    return imu(header + gyro.substr(gyro.find('\n') + 1),
               "accel_file: accel.txt, sampling: instant, " + more +
                   " columns: {time: {name: t}, gyro: {names: [x, y, z]}, accel: {names: [x, y, z], time: {name: s}" +
                   added + "}}");
  };
  const std::vector<double> all = evenly(1, 1.995, 0.01);
  const ImuRecording log = with(all);
  ASSERT_EQ(log.time.size(), 100U);
  EXPECT_TRUE(log.accel[50].isApprox(Vector3d(0.75, 0, 1.5 + 9.75)));
  EXPECT_EQ(log.unpaired, 0U);
  std::vector<double> most = all;
  most.resize(98);
  EXPECT_EQ(with(most).time.size(), 98U) << "what has no gravity is left out";
  EXPECT_TRUE(contains(refused([&] { with(evenly(1.003, 1.995, 0.01)); }),
                       "gravity.txt:1: only 0 of its 100 rows have the time of a row of"));
  EXPECT_TRUE(contains(refused([&] { with(all, "gravity_file: gravity.txt,", ""); }),
                       "its columns are those of `added` under `accel`"));
}

// A row of the accelerometers is the mean over the interval before it: what they add up to is kept at any rate.
TEST_F(Apart, MeansKeepTheVelocity) {
  for (const double step : {0.0025, 0.01, 0.037}) {
    const auto log = read_apart(evenly(0.9, 2.1, step));
    ASSERT_GT(log.time.size(), 95u);
    double velocity = 0;
    for (std::size_t i = 1; i < log.time.size(); ++i) velocity += log.accel[i].z() * (log.time[i] - log.time[i - 1]);
    const double first = log.time.front(), last = log.time.back();
    // As row t is the mean before t, it is that of the middle of the interval.
    const double expected = (9 + step / 2) * (last - first) + (last * last - first * first) / 2;
    EXPECT_NEAR(velocity, expected, 2e-3 * step / 0.0025) << step;
  }
}

TEST_F(Apart, RowsWithoutNeighboursAreLeftOutAndCounted) {
  auto times = evenly(1.2, 1.5, 0.01);
  for (const double t : evenly(1.7, 3, 0.01)) times.push_back(t);
  const auto log = read_apart(times, "sampling: instant,");
  EXPECT_NEAR(log.time.front(), 1.2, 0.011);
  EXPECT_TRUE(std::none_of(log.time.begin(), log.time.end(), [](double t) { return t > 1.505 && t < 1.695; }));
  const std::size_t beyond = 100;  // rows of the accelerometers after the gyroscopes' 1.99 s, to one or two
  EXPECT_NEAR(static_cast<double>(log.unpaired), static_cast<double>(100 - log.time.size() + beyond), 2);
  EXPECT_TRUE(contains(refused([&] { read_apart(evenly(7, 8, 0.01)); }), "imu.txt:1: no time in common with"));
}

// ---- Receivers ----

const std::string kPhoneHeader =
    "Boot [ns]; UTC time [ms]; Lat [deg]; Lon [deg]; Height [m]; Speed [m/s]; Heading [deg]; Hor Acc [m]; Vert Acc "
    "[m]; "
    "Speed Acc [m/s]; Heading Acc [deg]\n";
const std::string kPhone =
    "columns: {time: {name: UTC time, of: unix}, latitude: {name: Lat}, longitude: {name: Lon}, height: {name: "
    "Height}, "
    "speed: {name: Speed}, course: {name: Heading}, horizontal_accuracy: {name: Hor Acc}, vertical_accuracy: {name: "
    "Vert "
    "Acc}, speed_accuracy: {name: Speed Acc}, course_accuracy: {name: Heading Acc}}";

TEST_F(Columns, APhonesReceiver) {
  const auto log = gnss(kPhoneHeader +
                            "1;1604477851437;48.5;9.5;360.0;20;90.0;3.0192;100;0.5;10;\n"
                            "2;1604477852000;48.5;9.5;360.0;;;3.0;100;0.5;10;\n",
                        kPhone);
  ASSERT_EQ(log.fixes.size(), 2u);
  const GeodeticFix& fix = log.fixes[0];
  EXPECT_NEAR(fix.time, 3 * 86400 + 8 * 3600 + 17 * 60 + 31.437 + 18, 1e-6);
  EXPECT_NEAR(fix.position.latitude, 48.5 * kDegree, 1e-12);
  // 68 % of the errors of two axes are within 1.5096 sigmas.
  EXPECT_NEAR(fix.sigma_position.x(), 2, 1e-4);
  EXPECT_EQ(fix.sigma_position.z(), 100);
  ASSERT_TRUE(fix.velocity);
  EXPECT_NEAR(fix.velocity->value.x(), 0, 1e-12);
  EXPECT_NEAR(fix.velocity->value.y(), 20, 1e-12);
  EXPECT_NEAR(fix.velocity->sigma.x(), 20 * 10 * kDegree, 1e-12) << "across the course";
  EXPECT_FALSE(fix.velocity->has_down());
  EXPECT_FALSE(log.fixes[1].velocity) << "it says none";
}

// As robots log them: east, north, up.
TEST_F(Columns, CovarianceOfAPlace) {
  const std::string header = "t lat lon h a b c d e f g h2 i\n", row = "1 46 7 100 4 3 -1 3 9 2 -1 2 16\n";
  const std::string keys = "columns: {time: {name: t, unit: s}, " + kPlace +
                           ", covariance: {names: [a, b, c, d, e, f, g, h2, i], unit: m^2, axes: east north up}}";
  const GeodeticFix fix = gnss(header + row, keys).fixes.at(0);
  EXPECT_EQ(fix.sigma_position, Vector3d(3, 2, 4));
  EXPECT_TRUE(fix.correlation.isApprox(Correlation(0.5, -1.0 / 6, 0.125), 1e-12)) << fix.correlation.transpose();
  EXPECT_EQ(gnss(header + row, keys + ", sigma: 1 1 1 m").fixes.at(0).correlation, Correlation::Zero());
  EXPECT_TRUE(contains(refused([&] {
                         gnss(header + row, "columns: {time: {name: t, unit: s}, " + kPlace +
                                                ", covariance: {names: [a, b, c], unit: m^2}}");
                       }),
                       "9 are expected"));
}

TEST_F(Columns, StatedSigmasReplaceThose) {
  const auto log = gnss(kPhoneHeader + "1;1604477851437;48.5;9.5;360.0;20;90.0;3;100;0.5;10;\n",
                        kPhone + ", sigma: 3 4 6 m, sigma_velocity: 0.1 m/s");
  EXPECT_EQ(log.fixes[0].sigma_position, Vector3d(3, 4, 6));
  EXPECT_EQ(log.fixes[0].velocity->sigma.head<2>(), Eigen::Vector2d(0.1, 0.1));
  EXPECT_FALSE(log.fixes[0].velocity->has_down());
}

TEST_F(Columns, IntegersOfUbloxVelocitiesUpwardsAndFixes) {
  const std::string header = "iTOW,lat,lon,h,vE,vN,vU,sE,sN,sU,type\n";
  const auto log =
      gnss(header +
               "1000,465000000,72500000,1600000,1000,2000,3000,100,200,300,3\n"
               "2000,0,0,0,0,0,0,0,0,0,0\n3000,465000000,72500000,1600000,1,2,3,100,200,300,4\n",
           "sigma: 1 1 2 m, columns: {time: {name: iTOW, unit: ms, of: gps_week}, latitude: {name: lat, unit: "
           "1e-7 deg}, longitude: {name: lon, unit: 1e-7 deg}, height: {name: h, unit: mm}, velocity: {names: "
           "[vE, vN, vU], axes: east north up, unit: mm/s}, sigma_velocity: {names: [sE, sN, sU], axes: east "
           "north up, unit: mm/s}, fix: {name: type, valid: [3, 4]}}");
  ASSERT_EQ(log.fixes.size(), 2u);
  EXPECT_EQ(log.without_fix, 1u);
  EXPECT_EQ(log.fixes[0].time, 1);
  EXPECT_NEAR(log.fixes[0].position.longitude, 7.25 * kDegree, 1e-12);
  EXPECT_EQ(log.fixes[0].position.height, 1600);
  EXPECT_TRUE(log.fixes[0].velocity->value.isApprox(Vector3d(2, 1, -3)));
  EXPECT_TRUE(log.fixes[0].velocity->sigma.isApprox(Vector3d(0.2, 0.1, 0.3)));
}

// The other tables of fixes: LogIo.RowsWithoutAPlaceAreWithoutFix.
TEST_F(Columns, ARowWithoutAPlaceIsWithoutFix) {
  const auto log = gnss("t,lat,lon,h\n0,0,0,0\n0,0,0,0\n1,46,0,500\n2,0,7,500\n",
                        "sigma: 1 1 2 m, columns: {time: {name: t, unit: s}, " + kPlace + "}");
  EXPECT_EQ(log.without_fix, 2u);
  ASSERT_EQ(log.fixes.size(), 2u) << "on the meridian, and on the equator";
}

TEST_F(Columns, AnEmptyPlaceIsNoFix) {
  const auto log = gnss("t,lat,lon,h\n0,,,\n1,46,7,500\n2,46,7,nan\n3,46,7,500\n",
                        "sigma: 1 1 2 m, columns: {time: {name: t, unit: s}, " + kPlace + "}");
  EXPECT_EQ(log.without_fix, 2u);
  EXPECT_EQ(log.fixes.size(), 2u);
}

TEST_F(Columns, PlacesAsNmeaHasThem) {
  const std::string columns =
      "sigma: 1 1 2 m, columns: {time: {name: t, unit: s}, latitude: {name: lat, hemisphere: ns, unit: ddmm}, "
      "longitude: {name: lon, hemisphere: ew, unit: ddmm}, height: {name: alt, geoid: sep, unit: m}}";
  const auto log =
      gnss("t,lat,ns,lon,ew,alt,sep\n0,4605.838,S,713.716,W,450,50.5\n1,4605.838,N,713.716,e,450,50.5\n", columns);
  EXPECT_NEAR(log.fixes[0].position.latitude, -(46 + 5.838 / 60) * kDegree, 1e-12);
  EXPECT_NEAR(log.fixes[0].position.longitude, -(7 + 13.716 / 60) * kDegree, 1e-12);
  EXPECT_NEAR(log.fixes[1].position.longitude, (7 + 13.716 / 60) * kDegree, 1e-12);
  EXPECT_NEAR(log.fixes[0].position.height, 500.5, 1e-9);
  EXPECT_TRUE(contains(
      refused([&] { gnss("t,lat,ns,lon,ew,alt,sep\n0,4605.838,E,713.716,W,450,0\n1,1,N,1,E,1,1\n", columns); }),
      "is no hemisphere of the latitude"));
  EXPECT_TRUE(contains(
      refused([&] { gnss("t,lat,ns,lon,ew,alt,sep\n0,4675.838,N,713.716,W,450,0\n1,1,N,1,E,1,1\n", columns); }),
      "minutes of arc"));
}

TEST_F(Columns, QuotesMayHoldTheSeparator) {
  const auto log = gnss("\"t\",\"lat\",\"lon\",\"h\",\"note\"\n\"1\",\"46\",\"7\",\"500\",\"a, b\"\n2,46,7,500,c\n",
                        "sigma: 1 1 2 m, columns: {time: {name: t, unit: s}, " + kPlace + "}");
  ASSERT_EQ(log.fixes.size(), 2u);
  EXPECT_EQ(log.fixes[0].time, 1);
}

TEST_F(Columns, AxesOfASensor) {
  const auto with = [&](const std::string& axes) {
    return imu("t,gx,gy,gz,ax,ay,az\n1,1,2,3,4,5,6\n2,1,2,3,4,5,6\n",
               "columns: {time: {name: t, unit: s}, gyro: {names: [gx, gy, gz], unit: rad/s}, accel: {names: [ax, ay, "
               "az], axes: " +
                   axes + ", unit: m/s^2}}");
  };
  EXPECT_EQ(with("-x -y -z").accel[0], Vector3d(-4, -5, -6));
  EXPECT_EQ(with("y x -z").accel[0], Vector3d(5, 4, -6));
  EXPECT_EQ(with("+z +x +y").accel[0], Vector3d(5, 6, 4));
  EXPECT_EQ(with("+z +x +y").gyro[0], Vector3d(1, 2, 3));
  EXPECT_TRUE(contains(refused([&] { with("+x +x +z"); }), "one axis for each column is expected, such as `+x -y -z`"));
  EXPECT_TRUE(contains(refused([&] { with("+x +y up"); }), "`up` is no axis"));
}

TEST_F(Columns, ReceiversThatAreRefused) {
  const std::string time = "columns: {time: {name: t, unit: s}, ", rows = "t lat lon h a\n1 46 7 100 3\n2 46 7 100 3\n";
  const auto with = [&](const std::string& keys) { return refused([&] { gnss(rows, keys); }); };
  EXPECT_TRUE(contains(with(time + kPlace + "}"), "run.yaml:2: no sigmas: state `sigma: 3 3 6 m`"));
  EXPECT_TRUE(contains(with(time + kPlace + ", horizontal_accuracy: {name: a, unit: m}}"),
                       "columns: `vertical_accuracy` is missing"));
  EXPECT_TRUE(contains(with("sigma: 1 1 1 m, " + time + kPlace + ", speed: {name: a, unit: m/s}}"),
                       "columns: `course` is missing"));
  EXPECT_TRUE(contains(with("sigma: 1 1 1 m, " + time + kPlace + ", velocity: {names: [a, a], unit: m/s}}"),
                       "velocities without sigmas"));
  EXPECT_TRUE(contains(with("sigma: 1 1 1 m, " + time + "latitude: {name: lat, unit: deg}}"),
                       "columns: `longitude` is missing"));
  EXPECT_TRUE(contains(
      with("sigma: 1 1 1 m, " + time + kPlace +
           ", velocity: {names: [a, a, a], axes: up up north, unit: m/s}, sigma_velocity: {name: a, unit: m/s}}"),
      "axes: one axis for each column is expected"));
  EXPECT_TRUE(contains(refused([&] {
                         gnss("t,lat,lon,h,a\n1,46,7,100,3\n2,46,7,100,nan\n",
                              time + kPlace + ", sigma: {names: [a, a, a], unit: m}}");
                       }),
                       "gnss.txt:3: no sigma in this row; `sigma: 3 3 6 m`"));
}

TEST_F(Columns, AttitudeOfAnyNames) {
  folder.write("attitude.txt", "time;r;p;y\n1;1;2;359\n2;1;2;-1\n");
  folder.write("imu.txt", "t gx gy gz ax ay az\n1 0 0 0 0 0 1\n2 0 0 0 0 0 1\n");
  folder.write("gnss.txt", "t lat lon h\n1 46 7 100\n2 46 7 100\n");
  const auto log = read(
                       "columns: {time: {name: t, unit: s}, gyro: {names: [gx, gy, gz], unit: deg/s}, accel: {names: "
                       "[ax, ay, az], unit: g}}",
                       "sigma: 1 1 1 m, columns: {time: {name: t, unit: s}, " + kPlace + "}",
                       "attitude: {file: attitude.txt, format: columns, sigma: 0.1 0.1 0.2 deg, columns: {time: {name: "
                       "time, unit: s}, "
                       "angles: {names: [r, p, y], unit: deg}}}\n")
                       .attitude.at(0);
  EXPECT_TRUE(log.fixes.at(0).angles.isApprox(Vector3d(1, 2, 359) * kDegree));
  EXPECT_TRUE(log.fixes.at(0).sigma.isApprox(Vector3d(0.1, 0.1, 0.2) * kDegree));
}

// As VBOX has them: minutes of arc, to the west.
TEST_F(Columns, LongitudesThatGrowToTheWest) {
  const auto place = [&](const std::string& axes, const std::string& south) {
    return gnss("t,lat,lon,h\n1,2790,-435,100\n2,2790,-435,100\n",
                "sigma: 1 1 1 m, columns: {time: {name: t, unit: s}, latitude: {name: lat, unit: arcmin" + south +
                    "}, longitude: {name: lon, unit: arcmin" + axes + "}, height: {name: h, unit: m}}")
        .fixes.at(0)
        .position;
  };
  EXPECT_NEAR(place(", axes: west", "").longitude, 7.25 * kDegree, 1e-12);
  EXPECT_NEAR(place(", axes: east", "").longitude, -7.25 * kDegree, 1e-12);
  EXPECT_NEAR(place("", ", axes: south").latitude, -46.5 * kDegree, 1e-12);
  EXPECT_TRUE(contains(refused([&] { place(", axes: north", ""); }), "right would be `east` or `west`"));
  EXPECT_TRUE(contains(refused([&] { place(", axes: west, hemisphere: h", ""); }), "not with `hemisphere`"));
}

// ---- What the configuration says reads back ----

TEST_F(Columns, TheirTextReadsBack) {
  ColumnMap map;
  map.time = {"Timestamp [ns]", "ns", TimeScale::kBoot, {}, {}};
  map.accel_time = ColumnTime{"t: 2", "ms", TimeScale::kBoot, {}, {}};
  map.rows = {{"kind", "a: b"}, {"3", "0"}};
  map.accel_rows = {{"kind", "c"}};
  map.uses["gyro"] = {{"a b", "c", "3"}, "deg/s", {}, {}};
  map.uses["accel"] = {{"x", "y", "z"}, "1.2e-4 g", {}, {"gx", "gy", "gz"}};
  folder.write("sensor.yaml", kSensorOfColumns);
  folder.write("imu.txt", "");
  const Config config =
      Config::parse("imu: {file: imu.txt, accel_file: imu.txt, sensor: sensor.yaml, format: columns,\n  columns: " +
                        columns_text(map, "    ") + "}\n",
                    folder / "run.yaml");
  const ImuSource source = read_imu_source(config.map("imu"));
  ASSERT_TRUE(source.log.columns);
  EXPECT_EQ(columns_text(*source.log.columns, ""), columns_text(map, ""));
  EXPECT_EQ(*source.log.columns, map);
  EXPECT_EQ(source.log.columns->find("gyro")->names[0], "a b");
  EXPECT_EQ(source.log.columns->accel_time->name, "t: 2");
}

// ---- Repair ----

TEST_F(Columns, RepairSortsAndDropsAndCounts) {
  const std::string rows =
      "10;1;0;0;0;0;1;\n40;4;0;0;0;0;1;\n20;2;0;0;0;0;1;\n20;9;0;0;0;0;1;\n30;3;0;0;0;0;1;\n50;5;0;0;0;0;1;\n";
  const auto log = imu(kNamedHeader + rows, "repair: true, " + kNamed);
  EXPECT_EQ(log.time, (std::vector<double>{0.01, 0.02, 0.03, 0.04, 0.05}));
  for (std::size_t i = 0; i < 5; ++i) EXPECT_NEAR(log.gyro[i].x(), static_cast<double>(i + 1) * kDegree, 1e-12);
  EXPECT_EQ(log.repaired.sorted, 3u);
  EXPECT_EQ(log.repaired.dropped, 1u);
}

TEST(Repair, OfEveryReaderAndAcrossAWeeksEnd) {
  LogFile log{.file = "log", .format = LogFormat::kCsv, .repair = true};
  const std::string header = "time_s,latitude_deg,longitude_deg,height_m,sigma_north_m,sigma_east_m,sigma_down_m\n";
  const std::string place = ",46,7,100,1,1,1\n",
                    text = header + "604798" + place + "0.5" + place + "604799" + place + "1.5" + place + "0.5" + place;
  log.content = text;
  const GnssRecording gnss = read_gnss(log);
  ASSERT_EQ(gnss.fixes.size(), 4u);
  EXPECT_EQ(gnss.fixes[1].time, 604799);
  EXPECT_EQ(gnss.fixes[3].time, 604801.5);
  EXPECT_EQ(gnss.repaired.sorted, 2u);
  EXPECT_EQ(gnss.repaired.dropped, 1u);
  const std::string increments = "1 0 0 0.1 0 0 9.8\n3 0 0 0.3 0 0 9.8\n2 0 0 0.2 0 0 9.8\n3 0 0 0.4 0 0 9.8\n";
  log.format = LogFormat::kKfGins;
  log.content = increments;
  const ImuRecording imu = read_imu(log);
  EXPECT_EQ(imu.time, (std::vector<double>{1, 2, 3}));
  EXPECT_EQ(imu.gyro[2].z(), 0.3) << "the first of two";
}

TEST(StatedSigma, OfACsvWithoutItsOwn) {
  LogFile log{.file = "log", .format = LogFormat::kCsv, .sigma = Vector3d(3, 3, 6)};
  const std::string text = "time_s,latitude_deg,longitude_deg,height_m\n1,46,7,100\n2,46,7,100\n";
  log.content = text;
  EXPECT_EQ(read_gnss(log).fixes[1].sigma_position, Vector3d(3, 3, 6));
  log.sigma.reset();
  EXPECT_TRUE(contains(message_of<DataError>([&] { read_gnss(log); }), "column sigma_north_m is missing"));
}

}  // namespace
}  // namespace piste
