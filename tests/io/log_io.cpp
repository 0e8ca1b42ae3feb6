#include "piste/io/log_io.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>

#include "piste/math/units.h"
#include "support/datasets.h"
#include "support/text_file.h"

namespace piste {
namespace {

using test::contains;
using test::message_of;
using test::TemporaryFolder;

struct LogIo : ::testing::Test {
  TemporaryFolder folder;
  LogFile log(const std::string& text, LogFormat format = LogFormat::kCsv) {
    return {folder.write("log", text), format};
  }
  std::string refused_imu(const std::string& text, LogFormat format = LogFormat::kCsv) {
    return message_of<DataError>([&] { read_imu(log(text, format)); });
  }
  std::string refused_gnss(const std::string& text, LogFormat format = LogFormat::kCsv) {
    return message_of<DataError>([&] { read_gnss(log(text, format)); });
  }
};

const std::string kGnssHeader = "time_s,latitude_deg,longitude_deg,height_m,sigma_north_m,sigma_east_m,sigma_down_m\n";

// ---- csv ----

TEST_F(LogIo, CsvRatesInDegreesAndG) {
  const auto imu =
      read_imu(log("accel_x_g,accel_y_g,accel_z_g,time_s,gyro_x_deg_s,gyro_y_deg_s,gyro_z_deg_s,temperature_degC,mag_x_"
                   "uT,mag_y_uT,mag_z_uT\n"
                   "0,0,-1,10,90,0,-180,21.5,20,-3,44\n0,0,-1,10.01,90,0,-180,21.6,20,-3,44\n"));
  EXPECT_FALSE(imu.increments);
  ASSERT_EQ(imu.time.size(), 2u);
  EXPECT_TRUE(imu.gyro[0].isApprox(Vector3d(90, 0, -180) * kDegree));
  EXPECT_TRUE(imu.accel[0].isApprox(Vector3d(0, 0, -9.80665)));
  EXPECT_EQ(imu.magnetic[1], Vector3d(20, -3, 44));
  EXPECT_EQ(imu.temperature[1], 21.6);
}

TEST_F(LogIo, CsvIncrements) {
  const auto imu =
      read_imu(log("time_s,dtheta_x_rad,dtheta_y_rad,dtheta_z_rad,dvel_x_m_s,dvel_y_m_s,dvel_z_m_s\n"
                   "10,0,0,0.01,0,0,-0.098\n10.01,0,0,0.01,0,0,-0.098\n"));
  EXPECT_TRUE(imu.increments);
  EXPECT_EQ(imu.gyro[1], Vector3d(0, 0, 0.01));
}

TEST_F(LogIo, CsvGnssWithVelocity) {
  const std::string header = kGnssHeader.substr(0, kGnssHeader.size() - 1);
  const auto gnss =
      read_gnss(log(header + ",velocity_north_m_s,velocity_east_m_s,velocity_down_m_s,sigma_velocity_north_m_s,"
                             "sigma_velocity_east_m_s,sigma_velocity_down_m_s\n"
                             "10,46.5,-7.25,1600,1,2,3,4,5,6,.1,.2,.3\n"));
  EXPECT_DOUBLE_EQ(gnss.fixes[0].position.latitude, 46.5 * kDegree);
  EXPECT_EQ(gnss.fixes[0].sigma_position, Vector3d(1, 2, 3));
  EXPECT_EQ(gnss.fixes[0].velocity->value, Vector3d(4, 5, 6));
  EXPECT_EQ(gnss.fixes[0].velocity->sigma, Vector3d(.1, .2, .3));
}

// Neither their times nor their sigmas are read.
TEST_F(LogIo, RowsWithoutAPlaceAreWithoutFix) {
  const auto expect = [&](const std::string& text, LogFormat format) {
    const GnssRecording gnss = read_gnss(log(text, format));
    EXPECT_EQ(gnss.without_fix, 2u) << name_of(format);
    ASSERT_EQ(gnss.fixes.size(), 2u) << name_of(format);
    EXPECT_NEAR(gnss.fixes[0].position.latitude, 46 * kDegree, 1e-12);
    EXPECT_EQ(gnss.fixes[1].position.longitude, 0);
  };
  expect(kGnssHeader + "0,0,0,0,0,0,0\n0,0,0,0,0,0,0\n10,46,7,500,1,1,2\n11,46,0,500,1,1,2\n", LogFormat::kCsv);
  expect("0 0 0 0 0 0 0\n0 0 0 0 0 0 0\n10 46 7 500 1 1 2\n11 46 0 500 1 1 2\n", LogFormat::kKfGins);
  expect(
      "%  GPST  latitude(deg) longitude(deg) height(m) Q ns sdn(m) sde(m) sdu(m)\n"
      "0 0 0 0 0 5 8 0 0 0\n0 0 0 0 0 5 8 0 0 0\n2300 10 46 7 500 5 8 1 1 2\n2300 11 46 0 500 5 8 1 1 2\n",
      LogFormat::kRtklibPos);
}

// Single rows; where they are many, it is not they that are wrong.
TEST_F(LogIo, RepairLeavesOutWhatCannotBeRead) {
  std::string text = kGnssHeader;
  for (int i = 0; i < 20; ++i) text += fmt::format("{},46,7,500,1,1,2\n", i);
  const auto repaired = [&](const std::string& more) {
    LogFile file = log(text + more, LogFormat::kCsv);
    file.repair = true;
    return read_gnss(file);
  };
  const GnssRecording gnss = repaired("20,46,x,500,1,1,2\n21,46,7,500");
  EXPECT_EQ(gnss.fixes.size(), 20U);
  EXPECT_EQ(gnss.repaired.unreadable, 2U);
  // A value that cannot be may be one of all, as of another unit.
  EXPECT_THROW(repaired("20,146,7,500,1,1,2\n"), DataError);
  EXPECT_THROW(read_gnss(log(text + "20,46,x,500,1,1,2\n", LogFormat::kCsv)), DataError);
  const std::string why =
      message_of<DataError>([&] { repaired("20,46,x,5,1,1,2\n21,46,x,5,1,1,2\n22,x,7,5,1,1,2\n"); });
  EXPECT_TRUE(contains(why, ":22: field 3, `x`, is no number")) << why;
}

TEST_F(LogIo, CsvAttitude) {
  const std::string header = "time_s,roll_deg,pitch_deg,heading_deg,sigma_roll_deg,sigma_pitch_deg,sigma_heading_deg\n";
  const auto attitude = read_attitude(log(header + "10,1,-2,359,0.01,0.02,0.05\n"));
  EXPECT_TRUE(attitude.fixes[0].angles.isApprox(Vector3d(1, -2, 359) * kDegree));
  EXPECT_TRUE(attitude.fixes[0].sigma.isApprox(Vector3d(0.01, 0.02, 0.05) * kDegree));
  EXPECT_TRUE(contains(message_of<DataError>([&] { read_attitude(log(header + "10,1,-92,359,1,1,1\n")); }),
                       "log:2: an angle is out of range"));
  EXPECT_TRUE(contains(message_of<DataError>([&] { read_attitude(log(header)); }), "holds no attitude"));
}

TEST_F(LogIo, WrongUnitsAreSeenByTheirSize) {
  const std::string header = "time_s,gyro_x_rad_s,gyro_y_rad_s,gyro_z_rad_s,accel_x_m_s2,accel_y_m_s2,accel_z_m_s2\n";
  EXPECT_TRUE(
      contains(refused_imu(header + "1,0,0,0,0,0,-9.8\n2,0,0,250,0,0,-9.8\n"), "log:3: an angular rate of 250"));
  EXPECT_TRUE(contains(refused_imu(header + "1,0,0,0,0,0,-9.8\n2,0,0,250,0,0,-9.8\n"), "these look like degrees"));
  const std::string g = refused_imu(header + "1,0,0,0,0,0,-1\n2,0,0,0,0,0,-1\n");
  EXPECT_TRUE(contains(g, "log:1: the median specific force is 1 m/s^2"));
  EXPECT_TRUE(contains(g, "accel_x_g"));
  const std::string in_g = "time_s,gyro_x_deg_s,gyro_y_deg_s,gyro_z_deg_s,accel_x_g,accel_y_g,accel_z_g\n";
  EXPECT_TRUE(
      contains(refused_imu(in_g + "1,0,0,0,0,0,-1\n2,0,0,0,0,0,-1e308\n"), "log:3: a value is not finite in SI"));
  EXPECT_TRUE(
      contains(refused_gnss(kGnssHeader + "1,146.5,7.25,1600,1,1,1\n"), "log:2: latitude 146.500000 deg is beyond 90"));
  EXPECT_TRUE(contains(refused_gnss(kGnssHeader + "1,146.5,7.25,1600,1,1,1\n"), "latitude and longitude exchanged?"));
  EXPECT_TRUE(contains(refused_gnss(kGnssHeader + "1,46.5,7.25,1600,1,0,1\n"), "log:2: the sigmas of a position"));
}

TEST_F(LogIo, MissingColumnsAndRows) {
  EXPECT_TRUE(contains(refused_imu("time_s,x\n1,2\n"), "log:1: no gyroscope"));
  const std::string rpm = refused_imu("time_s,gyro_x_rpm,gyro_y_rpm,gyro_z_rpm\n1,2,3,4\n");
  EXPECT_TRUE(contains(rpm, "`gyro_x_rpm` is in a unit that is not known; the columns are: time_s, gyro_x_rpm")) << rpm;
  EXPECT_TRUE(contains(refused_imu("time_s,gyro_x_rad_s,gyro_y_rad_s,gyro_z_rad_s\n1,2,3,4\n"),
                       "accel_x_m_s2 or accel_x_g is missing"));
  EXPECT_TRUE(contains(refused_imu("time_s,gyro_x_rad_s,gyro_y_rad_s\n1,2,3\n"), "column `gyro_z_rad_s` is missing"));
  EXPECT_TRUE(contains(refused_gnss(kGnssHeader), "holds no fix"));
  EXPECT_TRUE(contains(refused_gnss(kGnssHeader + "2,46.5,7,1600,1,1,1\n2,46.5,7,1600,1,1,1\n"),
                       "log:3: time 2.000000 s does not increase"));
  EXPECT_TRUE(contains(refused_gnss(kGnssHeader + "2,46.5,7,nan,1,1,1\n"), "log:2: field 4"));
}

// ---- kf_gins ----

TEST_F(LogIo, KfGins) {
  const auto imu = read_imu(log("10 0 0 .01 0 0 -0.098\r\n10.01\t0 0 .01 0 0 -0.098\n", LogFormat::kKfGins));
  EXPECT_TRUE(imu.increments);
  EXPECT_EQ(imu.accel[1], Vector3d(0, 0, -0.098));
  const auto gnss = read_gnss(log("10 46.5 7.25 1600 1 2 3 4 5 6 .1 .2 .3 1\n", LogFormat::kKfGins));
  EXPECT_EQ(gnss.fixes[0].velocity->value, Vector3d(4, 5, 6));
  EXPECT_TRUE(contains(refused_imu("10 0 0 .01 0 0 -0.098\n10.01 0 0\n", LogFormat::kKfGins),
                       "log:2: 3 fields; 7 are expected"));
  EXPECT_TRUE(contains(refused_gnss("10 46.5 7.25 1600 1 2\n", LogFormat::kKfGins), "log:1: 6 fields; 7 are expected"));
  EXPECT_TRUE(contains(refused_gnss("10 46.5 7 1600 1 2 3\n11 46.5 7 1600 1 2 x\n", LogFormat::kKfGins),
                       "log:2: field 7, `x`, is no number"));
}

// ---- rtklib_pos ----

const std::string kPosition = " Q ns sdn(m) sde(m) sdu(m) sdne(m) sdeu(m) sdun(m) age(s) ratio";
const std::string kRest = " 1 9 1 2 3 0 0 0 0 9\n";

std::string header(const std::string& time, const std::string& angle = "deg") {
  return "% program   : RTKLIB\n%  " + time + "  latitude(" + angle + ") longitude(" + angle + ") height(m)" +
         kPosition + "\n";
}

double first_time(const GnssRecording& gnss) { return gnss.fixes.at(0).time; }

TEST_F(LogIo, RtklibTimes) {
  const auto time = [&](const std::string& text) { return first_time(read_gnss(log(text, LogFormat::kRtklibPos))); };
  const std::string place = " 46.5 7.25 1600" + kRest;
  EXPECT_EQ(time(header("GPST") + "2025/07/08 19:34:18.499" + place), 243258.499);  // Tuesday
  EXPECT_EQ(time(header("UTC") + "2025/07/08 19:34:00.499" + place), 243258.499);   // 18 leap seconds
  EXPECT_EQ(time(header("UTC") + "2006/01/01 00:00:00" + place), 14);               // Sunday, the day it became 14
  EXPECT_EQ(time(header("UTC") + "2005/12/31 23:59:59" + place), 604799 + 13);
  EXPECT_EQ(time(header("GPST") + "2374 243258.499" + place), 243258.499);
  EXPECT_EQ(time(header("UTC") + "2374 243240.499" + place), 243258.499);
  EXPECT_EQ(time(header("JST") + "2025/07/09 04:34:00.499" + place), 243258.499);
  EXPECT_EQ(time(header("JST") + "2374 275640.499" + place), 243258.499);
  EXPECT_EQ(time(header("JST") + "2006/01/01 08:59:59" + place), 604799 + 13);  // still 2005 in UTC
  const auto rolled = read_gnss(log(
      header("GPST") + "2025/07/12 23:59:59.500" + place + "2025/07/13 00:00:00.500" + place, LogFormat::kRtklibPos));
  EXPECT_EQ(rolled.fixes[0].time, 604799.5);
  EXPECT_EQ(rolled.fixes[1].time, 604800.5);
}

TEST_F(LogIo, RtklibAngles) {
  const auto gnss =
      read_gnss(log(header("GPST", "d'\"") + "2374 1 -0 30 00.0 7 15 36.0 1600" + kRest, LogFormat::kRtklibPos));
  EXPECT_DOUBLE_EQ(gnss.fixes[0].position.latitude, -0.5 * kDegree);
  EXPECT_DOUBLE_EQ(gnss.fixes[0].position.longitude, 7.26 * kDegree);
  EXPECT_EQ(gnss.fixes[0].sigma_position, Vector3d(1, 2, 3));
  EXPECT_FALSE(gnss.fixes[0].velocity);
}

// sdne, sdeu and sdun are roots of covariances, with their signs; up is against down.
TEST_F(LogIo, RtklibCorrelations) {
  const auto fix = [&](const std::string& deviations, bool stated = false) {
    LogFile file = log(header("GPST") + "2374 1 46.5 7.25 1600 1 9 " + deviations + " 0 9\n", LogFormat::kRtklibPos);
    if (stated) file.sigma = Vector3d(1, 1, 1);
    return read_gnss(file).fixes.at(0);
  };
  const GeodeticFix some = fix("0.02 0.01 0.04 -0.01 0.01 0.02");
  EXPECT_TRUE(some.correlation.isApprox(Correlation(-0.5, -0.5, -0.25), 1e-12)) << some.correlation.transpose();
  EXPECT_EQ(fix("1 2 3 0 0 0").correlation, Correlation::Zero());
  EXPECT_LT(fix("0.02 0.01 0.05 0.02 0 0").correlation.x(), 1) << "of which no covariance is made";
  EXPECT_EQ(fix("0.02 0.01 0.04 -0.01 0.01 0.02", true).correlation, Correlation::Zero()) << "of the stated sigmas";
}

TEST_F(LogIo, CsvCorrelations) {
  const std::string named = kGnssHeader.substr(0, kGnssHeader.size() - 1) +
                            ",correlation_north_east,correlation_north_down,correlation_east_down\n";
  EXPECT_EQ(read_gnss(log(named + "10,46,7,500,1,1,2,0.5,-0.25,0.125\n")).fixes.at(0).correlation,
            Correlation(0.5, -0.25, 0.125));
  EXPECT_TRUE(contains(refused_gnss(named + "10,46,7,500,1,1,2,1.5,0,0\n", LogFormat::kCsv), "between -1 and 1"));
}

TEST_F(LogIo, RtklibRefusals) {
  const auto refused = [&](const std::string& text) { return refused_gnss(text, LogFormat::kRtklibPos); };
  const std::string place = " 46.5 7.25 1600" + kRest;
  EXPECT_TRUE(
      contains(refused("2374 1 46.5 7.25 1600 1 9\n"), "log:1: no header line before the first fix, and 7 fields"));
  EXPECT_TRUE(
      contains(refused(header("GPST") + "2374 1 46.5 7.25 1600 1 9\n"), "log:3: 7 fields, but the header promises 15"));
  EXPECT_TRUE(
      contains(refused(header("GPST") + "2025/13/08 19:34:18" + place), "log:3: `2025/13/08 19:34:18` is no time"));
  EXPECT_TRUE(contains(refused(header("GPST") + "2025/nan/08 19:34:18" + place), "is no time"));
  EXPECT_TRUE(contains(refused(header("GPST") + "2025/07/08 25:34:18" + place), "is no time"));
  EXPECT_TRUE(contains(refused(header("EST") + "2025/07/08 19:34:18" + place), "log:2: time system `EST`"));
  EXPECT_TRUE(contains(refused(header("GPST") + "2374 700000" + place), "log:3: `2374 700000` is no time"));
  EXPECT_TRUE(
      contains(refused(header("GPST") + "2374 1 46.5 7.25 1600 8 9 1 2 3 0 0 0 0 9\n"), "log:3: quality Q = 8"));
  EXPECT_TRUE(
      contains(refused(header("GPST") + "2025/07/12 10:00:00" + place + "2025/07/08 10:00:00" + place), "log:4: time"));
  EXPECT_TRUE(contains(refused("% (lat/lon/height=Tokyo/ellipsoidal,Q=1:fix)\n"), "out-datum=wgs84"));
  EXPECT_TRUE(contains(refused("%  GPST  x-ecef(m) y-ecef(m) z-ecef(m) Q\n"),
                       "log:1: latitude, longitude and height are expected"));
  EXPECT_TRUE(contains(refused("% (lat/lon/height=WGS84/geodetic,Q=1:fix)\n"), "out-height=ellipsoidal"));
}

TEST_F(LogIo, RtklibSeparatorsAndQuality) {
  const std::string spaces =
      header("GPST") + "2374 1 46.5 7.25 1600" + kRest + "2374 2 46.5 7.25 1600 6 9 1 2 3 0 0 0 0 9\n";
  for (const char separator : {',', '\t', ';'}) {
    std::string text = spaces;
    std::replace(text.begin() + static_cast<std::ptrdiff_t>(text.find("\n%") + 3), text.end(), ' ', separator);
    const auto gnss = read_gnss(log(text, LogFormat::kRtklibPos));
    ASSERT_EQ(gnss.fixes.size(), 2u) << separator;
    EXPECT_EQ(gnss.fixes[0].quality, FixQuality::kFixed);
    EXPECT_EQ(gnss.fixes[1].quality, FixQuality::kPrecise);
    EXPECT_EQ(gnss.fixes[1].satellites, 9);
  }
}

// ---- recorded ----

TEST(RecordedDrive, RtklibAndKfGinsAgree) {
  PISTE_REQUIRE_DATASETS();
  const auto drive = test::datasets() / "drive";
  const auto pos = read_gnss({drive / "gnss_1934_sf.pos", LogFormat::kRtklibPos});
  const auto text = read_gnss({drive / "gnss.txt", LogFormat::kKfGins});
  const auto full = read_gnss({drive / "gnss_full.txt", LogFormat::kKfGins});
  ASSERT_EQ(pos.fixes.size(), 2197u);
  ASSERT_EQ(text.fixes.size(), pos.fixes.size());
  ASSERT_EQ(full.fixes.size(), pos.fixes.size());
  for (std::size_t i = 0; i < pos.fixes.size(); ++i) {
    const GeodeticFix &a = pos.fixes[i], &b = text.fixes[i], &c = full.fixes[i];
    ASSERT_NEAR(a.time, b.time, 1e-9);
    ASSERT_NEAR(a.position.latitude, b.position.latitude, 1e-15);
    ASSERT_NEAR(a.position.longitude, b.position.longitude, 1e-15);
    ASSERT_NEAR(a.position.height, b.position.height, 1e-9);
    ASSERT_LT((a.sigma_position - b.sigma_position).cwiseAbs().maxCoeff(), 6e-5);
    ASSERT_LT((a.velocity->value - c.velocity->value).cwiseAbs().maxCoeff(), 6e-5);
    ASSERT_LT((a.velocity->sigma - c.velocity->sigma).cwiseAbs().maxCoeff(), 6e-5);
  }
}

TEST(RecordedDrive, ImuReads) {
  PISTE_REQUIRE_DATASETS();
  const auto imu = read_imu(LogFile{test::datasets() / "drive" / "imu.txt", LogFormat::kKfGins});
  EXPECT_EQ(imu.time.size(), 54858u);
  EXPECT_EQ(imu.time.front(), 243261.729);
}

}  // namespace
}  // namespace piste
