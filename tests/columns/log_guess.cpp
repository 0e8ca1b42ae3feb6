#include "piste/columns/log_guess.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "support/datasets.h"
#include "support/receiver_logs.h"
#include "support/text_file.h"

namespace piste {
namespace {

using test::contains;
using test::message_of;

struct Example {
  const char* name;
  LogKind kind;
  LogFormat format;
  std::string text;
};

std::vector<Example> examples() {
  return {
      {"imu_csv", LogKind::kImu, LogFormat::kCsv,
       "temperature_degC,time_s,dtheta_x_rad,dtheta_y_rad,dtheta_z_rad,dvel_x_m_s,dvel_y_m_s,dvel_z_m_s\n"},
      {"gnss_csv", LogKind::kGnss, LogFormat::kCsv,
       "time_s,latitude_deg,longitude_deg,height_m,sigma_north_m,sigma_east_m,sigma_down_m\r\n1,46,7,100,1,1,1\r\n"},
      {"solution_csv", LogKind::kGnss, LogFormat::kCsv,
       "time_s,latitude_deg,longitude_deg,height_m,roll_deg,pitch_deg,heading_deg\n"},
      {"attitude_csv", LogKind::kAttitude, LogFormat::kCsv, "time_s,roll_deg,pitch_deg,heading_deg\n"},
      {"imu_kf_gins", LogKind::kImu, LogFormat::kKfGins, "10.00 1e-5 0 0.01 0 0 -0.098\n10.01 0 0 .01 0 0 -0.098\n"},
      {"fast_imu_kf_gins", LogKind::kImu, LogFormat::kKfGins, "10.0 0.1 0 0.2 0 0.1 0.98\n10.1 0 0 .1 0 0.1 0.98\n"},
      {"gnss_kf_gins", LogKind::kGnss, LogFormat::kKfGins, "10 46.5 -7.2 1600 1 2 3\n11 46.5 -7.2 1600 1 2 3\n"},
      {"full_gnss_kf_gins", LogKind::kGnss, LogFormat::kKfGins, "10 46 7 1600 1 2 3 0 0 0 .1 .1 .1 1\n"},
      {"rtklib", LogKind::kGnss, LogFormat::kRtklibPos,
       "% program : RTKLIB\n%  GPST  latitude(deg) longitude(deg) height(m) Q ns\n"},
      {"nmea", LogKind::kGnss, LogFormat::kNmea, "\xFF\x01" + test::nmea("GNGGA,,,,,,0,,,,,,,,")},
      {"ubx", LogKind::kGnss, LogFormat::kUbx, test::ubx(1, 7, test::nav_pvt(1000).text())},
      {"nmea_before_ubx", LogKind::kGnss, LogFormat::kUbx,
       test::nmea("GNGGA,,,,,,0,,,,,,,,") + test::ubx(1, 7, test::nav_pvt(1000).text())},
      {"xsens", LogKind::kImu, LogFormat::kXsensAscii,
       "// Start Time: 0\n// Sample rate: 50.0Hz\nCounter\tAcc_X\tAcc_Y\tAcc_Z\tGyr_X\tGyr_Y\tGyr_Z\n"},
      {"imr", LogKind::kImu, LogFormat::kImr, test::imr_header().text()},
      {"inspva", LogKind::kAttitude, LogFormat::kInspva, test::novatel("#INSPVAA,COM1,0,31.0,FINESTEERING,1264,1;1")},
  };
}

class LogGuessed : public ::testing::TestWithParam<Example> {};

TEST_P(LogGuessed, ByWhatItHolds) {
  const LogGuess guess = guess_log("log", GetParam().text);
  EXPECT_EQ(guess.kind, GetParam().kind);
  EXPECT_EQ(guess.format, GetParam().format);
  EXPECT_FALSE(guess.why.empty());
}

INSTANTIATE_TEST_SUITE_P(Formats, LogGuessed, ::testing::ValuesIn(examples()),
                         [](const auto& each) { return each.param.name; });

// Logs of known kinds that cannot be used say what could be.
TEST(LogGuess, KnownLogsWithoutATime) {
  const auto why = [](const std::string& text) { return message_of<DataError>([&] { guess_log("log", text); }); };
  EXPECT_TRUE(contains(why("$VNIMU,-00.03,+00.42,-00.66,-00.01,+00.02,+09.95,+00.002,-00.008,-00.045,+20.7,+84.3*66\n"),
                       "log:1: holds sentences of VectorNav: VNIMU has no time"));
  const std::string place = "49.015 8.434 116.43 0.035 0.002 -2.6";
  std::string middle;
  for (int i = 0; i < 19; ++i) middle += fmt::format(" {}.25", i);
  EXPECT_TRUE(contains(why(place + middle + " 4 11 6 6 6\n"), "log:1: holds rows of KITTI's oxts"));
  EXPECT_FALSE(contains(why(place + middle + " 4 11 6 6 6.5\n"), "KITTI")) << "no modes";
}

// IMU, receiver and attitudes stand in one file of NovAtel.
TEST(LogGuess, SeveralLogsOfNovatel) {
  const std::string position = test::novatel("#BESTPOSA,COM1,0,60.0,FINESTEERING,2374,1.0,0,0,0;SOL_COMPUTED"),
                    typed = test::novatel("%RAWIMUSXA,2374,1.0;00,13"),
                    untyped = test::novatel("%RAWIMUSA,2374,1.0;2374"),
                    attitude = test::novatel("#INSPVAA,COM1,0,31.0,FINESTEERING,1264,1;1");
  const LogGuess all = guess_log("log", position + attitude + untyped + typed);
  EXPECT_EQ(all.kind, LogKind::kImu);
  ASSERT_EQ(all.beside.size(), 2U);
  EXPECT_EQ(all.beside[0].kind, LogKind::kGnss);
  EXPECT_EQ(all.beside[0].format, LogFormat::kNovatel);
  EXPECT_EQ(all.beside[1].part, LogGuess::Part::kNone) << all.beside[1].aside;
  const LogGuess without = guess_log("log", untyped + attitude + position);
  EXPECT_EQ(without.kind, LogKind::kGnss);
  ASSERT_EQ(without.beside.size(), 2U);
  EXPECT_EQ(without.beside[0].part, LogGuess::Part::kWhole) << "of an IMU that is not in the file";
  EXPECT_TRUE(contains(without.beside[1].aside, "do not say the type of the IMU"));
}

TEST(LogGuess, SaysWhatIsNone) {
  const auto refused = [](const std::string& text) {
    return message_of<DataError>([&] { guess_log("log.txt", text); });
  };
  EXPECT_TRUE(contains(refused(""), "log.txt:1: the file is empty"));
  EXPECT_TRUE(contains(refused(" \r\n\n"), "the file is empty"));
  EXPECT_TRUE(contains(refused("t,gx,gy,gz,ax,ay,az\n1,2,3,4,5,6,7\n"), "begins with `t,gx,gy,gz,ax,ay,az`"));
  EXPECT_TRUE(contains(refused("1 2 3\n4 5 6\n"), "none of the logs"));
  EXPECT_TRUE(contains(refused(std::string("\x7f"
                                           "ELF\0\0\0\1",
                                           8)),
                       "is binary and none of the logs"));
}

// Signs of a format that its reader could not read.
TEST(LogGuess, SaysHowToPutRightWhatIsNoTable) {
  const auto why = [](const std::string& text) { return message_of<DataError>([&] { guess_log("log.txt", text); }); };
  EXPECT_TRUE(contains(why("09:17:31.050 -> 12, -5, 1024\n09:17:31.060 -> 13, -5, 1020\n"), "` -> `"));
  EXPECT_TRUE(contains(why("{\"t\": 1, \"ax\": 0.1}\n{\"t\": 2, \"ax\": 0.1}\n"), "holds JSON"));
  EXPECT_TRUE(contains(why("[\n {\n  \"t\": 1,\n  \"ax\": 0.1\n }\n]\n"), "holds JSON")) << "over several lines";
  EXPECT_TRUE(contains(why("<?xml version=\"1.0\"?>\n<gpx><trk/></gpx>\n"), "holds GPX"));
  EXPECT_TRUE(contains(why("time,lat,lon,alt\n2023,46.1,7.2,450.1\n1,46.1001,7.2001,450.2\n3,46.1002,7.2002,450.1\n"
                           "5,46.1003,7.2003,450.3\n"),
                       "column `time` keeps falling back (it falls back at row 2, from 2023 to 1)"));
}

// Stamps before the sentences of a receiver, and sentences as a field of other logs.
TEST(LogGuess, SentencesBehindAStamp) {
  const std::string gga = test::nmea("GNGGA,100000,4630.0,N,00715.0,W,1,12,0.8,1550.0,M,50.0,M,,");
  std::string stamped, several;
  for (int i = 0; i < 20; ++i) {
    stamped += fmt::format("{},1707307200.{:03},{}", i, 20 * i, gga);
    several += fmt::format("IMU,{},0.1,0.2\nIMU,{},0.1,0.2\nNMEA,{},{}", i, i, i, gga);
  }
  EXPECT_EQ(guess_log("putty.csv", stamped).format, LogFormat::kNmea);
  try {
    EXPECT_NE(guess_log("all.csv", several).format, LogFormat::kNmea);
  } catch (const DataError& e) {
    EXPECT_TRUE(contains(e.what(), "none of the logs"));
  }
}

TEST(LogGuess, SaysWhatAReceiverDoesNotWrite) {
  const auto why = [](const std::string& text) { return message_of<DataError>([&] { guess_log("log.txt", text); }); };
  EXPECT_TRUE(
      contains(why(test::nmea("GNRMC,100000,A,4630.0,N,00715.0,W,0.0,,080725,,,A")), "RMC and GLL have no height"));
  EXPECT_TRUE(contains(why("GNGGA,100000,4630.0,N,00715.0,W,1,12,0.8,1550,M,50,M,,\n"), "has rewritten"));
  EXPECT_TRUE(contains(why("$GNGGA;100000;4630,0;N;715,0;W;1;12;0,8;1550;M;50;M;;\n"), "has rewritten"));
  std::string old;
  for (int i = 0; i < 20; ++i) old += test::ubx(1, 2, std::string(28, '\0'));
  EXPECT_TRUE(contains(why(old), "has no NAV-PVT of u-blox, and its places stand in 20 NAV-POSLLH"));
  const std::string pvt = test::ubx(1, 7, test::nav_pvt(1000).text());
  EXPECT_TRUE(contains(why(pvt + old), "has only 1 NAV-PVT"));
  EXPECT_TRUE(contains(why(test::ubx(2, 0x15, std::string(16, '\0'))), "no NAV-PVT among them"));
}

// A program asks for single positions while the receiver writes sentences.
TEST(LogGuess, SentencesOutnumberFrames) {
  std::string text = test::ubx(1, 7, test::nav_pvt(1000).text());
  for (int i = 0; i < 9; ++i)
    text += test::nmea(fmt::format("GNGGA,10000{},4630.0,N,00715.0,W,1,12,0.8,1550.0,M,50.0,M,,", i));
  EXPECT_EQ(guess_log("com.ubx", text).format, LogFormat::kNmea);
}

// Numbers that begin with the time of day in three columns are no rows of KF-GINS.
TEST(LogGuess, FourteenNumbersThatAreNotKfGins) {
  std::string text;
  for (int i = 0; i < 400; ++i) {
    const double t = 0.25 * i;
    text += fmt::format("{:.2f} 9 {} {:.2f} {:.8f} {:.8f} {:.3f} 4 17 0.8 {:.3f} 31.5 23 12.6\n", t, 31 + i / 240,
                        std::fmod(t, 60), 46.5 + 1e-6 * i, 7.25 + 2e-6 * i, 612 + 0.01 * i, 5 + 0.1 * std::sin(t));
  }
  const LogGuess guess = guess_log("pos.txt", text);
  ASSERT_EQ(guess.format, LogFormat::kColumns);
  EXPECT_EQ(guess.columns->find("latitude")->names, std::vector<std::string>{"5"});
  EXPECT_EQ(guess.columns->find("height")->names, std::vector<std::string>{"7"});
  EXPECT_EQ(guess.columns->time.name, "1");
}

// Speeds near 10 m/s beside a place are no forces: they vanish at rest.
TEST(LogGuess, VelocitiesAreNoForces) {
  std::string text;
  for (int i = 0; i < 500; ++i) {
    const double t = 0.2 * i, v = i < 80 ? 0 : 9.6 + 0.5 * std::sin(t), course = 0.1 * t;
    text += fmt::format("2300 {:.1f} {:.9f} {:.9f} {:.4f} 1 14 0.02 0.02 0.03 {:.3f} {:.3f} {:.3f} 0.9\n", 216000 + t,
                        46.5 + 1e-6 * i, 7.25 + 2e-6 * i, 612 + 0.01 * i, v * std::cos(course) + 0.01 * (i % 3),
                        v * std::sin(course) + 0.01 * (i % 4), 0.01 * (i % 5));
  }
  const LogGuess guess = guess_log("pos.txt", text);
  EXPECT_EQ(guess.kind, LogKind::kGnss);
  EXPECT_EQ(guess.columns->find("latitude")->names, std::vector<std::string>{"3"});
}

TEST(LogGuess, RowsOfRtklibWithoutTheirHeader) {
  std::string calendar, week;
  for (int i = 0; i < 5; ++i) {
    const std::string rest = " 46.1000001 7.2000001 450.1 5 9 0.5 0.6 1.1 0.1 0.1 0.1 1.0 2.1\n";
    calendar += "2025/07/08 19:34:1" + std::to_string(i) + ".000" + rest;
    week += "2374 24327" + std::to_string(i) + ".000" + rest;
  }
  EXPECT_EQ(guess_log("a.pos", calendar).format, LogFormat::kRtklibPos);
  EXPECT_EQ(guess_log("a.llh", week).format, LogFormat::kRtklibPos);
  LogFile log{.file = "a.llh", .format = LogFormat::kRtklibPos, .content = week};
  const GnssRecording read = read_gnss(log);
  ASSERT_EQ(read.fixes.size(), 5U);
  EXPECT_EQ(read.fixes[1].time, 243271);
  EXPECT_EQ(read.fixes[0].sigma_position, Vector3d(0.5, 0.6, 1.1));
  EXPECT_EQ(read.fixes[0].quality, FixQuality::kSingle);
}

// Frames of a configuration before the sentences, none of them with a position.
TEST(LogGuess, SentencesBehindFramesAreNmea) {
  const std::string frame{"\xB5\x62\x05\x01\x02\x00\x06\x8A\x98\xC1", 10};
  const std::string gga = "$GPGGA,123519,4807.038,N,01131.000,E,1,08,0.9,545.4,M,46.9,M,,*47\n",
                    rmc = "$GPRMC,123519,A,4807.038,N,01131.000,E,022.4,084.4,230394,003.1,W*6A\n";
  EXPECT_EQ(guess_log("a.ubx", frame + gga + rmc).format, LogFormat::kNmea);
  const std::string text = frame + gga + frame + rmc;
  LogFile log{.file = "a.ubx", .format = LogFormat::kNmea, .content = text};
  log.sigma = Vector3d(3, 3, 6);
  EXPECT_EQ(read_gnss(log).fixes.size(), 1U);
}

// Day, month, year, hour, minute and second between a number and a quality: no place, and no sigmas.
TEST(LogGuess, ACalendarIsNoPlace) {
  std::string rows;
  for (int i = 0; i < 60; ++i) {
    rows += std::to_string(i + 1) + " 9 3 2025 8 " + std::to_string(20 + i / 30) + " " + std::to_string(2 * (i % 30)) +
            ".0 1 0.80454966 0.12616294 450.3" + std::to_string(i % 10) + " 0.011 0.013 0.02\n";
  }
  try {
    EXPECT_NE(guess_log("log.txt", rows).format, LogFormat::kKfGins);
  } catch (const DataError& refused) {
    EXPECT_TRUE(contains(refused.what(), "names")) << refused.what();
  }
}

TEST(LogGuess, WeakSignsAreNoFormat) {
  const auto rows = [](const std::string& header, char separator, const std::string& more = "") {
    std::string text = header;
    for (int i = 0; i < 300; ++i) {
      const double turn = 0.01 * ((7 * i) % 11 - 5);
      std::string row = fmt::format("{:.2f},{:.3f},{:.3f},0.01,0.1,{:.3f},-9.81{}\n", 400000 + 0.02 * i, turn, -turn,
                                    -0.1 + turn, more);
      std::replace(row.begin(), row.end(), ',', separator);
      text += row;
    }
    return text;
  };
  const std::string names = ",gyro_x_rad_s,gyro_y_rad_s,gyro_z_rad_s,accel_x_m_s2,accel_y_m_s2,accel_z_m_s2\n";
  const auto format = [](const std::string& text) { return guess_log("log.csv", text).format; };
  EXPECT_EQ(format(rows("time_s" + names, ',')), LogFormat::kCsv);
  EXPECT_EQ(format(rows("time_sec" + names, ',')), LogFormat::kColumns);
  EXPECT_EQ(format(rows("time_stamp" + names, ',')), LogFormat::kColumns);
  std::string semicolons = "time_s" + names;
  std::replace(semicolons.begin(), semicolons.end(), ',', ';');
  EXPECT_EQ(format(rows(semicolons, ';')), LogFormat::kColumns);
  const LogGuess thirteen = guess_log("imu.txt", rows("", ' ', ",20,1,-40,0.1,0.2,30"));
  EXPECT_EQ(thirteen.kind, LogKind::kImu);
  EXPECT_EQ(thirteen.format, LogFormat::kColumns);
}

// Places without a height are no receiver's log: it is said that they are not used.
TEST(LogGuess, SaysWhatIsLost) {
  const auto lost = [](const std::string& names, const std::string& values) {
    std::string text = "timestamp_s,gyro_x_rad_s,gyro_y_rad_s,gyro_z_rad_s,acc_x_m_s2,acc_y_m_s2,acc_z_m_s2," + names;
    for (int i = 0; i < 300; ++i) {
      const double turn = 0.01 * ((7 * i) % 11 - 5);
      text += fmt::format("\n{:.2f},{:.3f},{:.3f},0.01,0.1,{:.3f},-9.81,46.{:04},7.{:04}{}", 400000 + 0.02 * i, turn,
                          -turn, -0.1 + turn, 1000 + i, 2000 + i, values);
    }
    return guess_log("log.csv", text).lost;
  };
  EXPECT_TRUE(contains(lost("latitude,longitude", ""), "none is known for its height"));
  EXPECT_TRUE(lost("latitude,longitude,height_m", ",500").empty());
}

TEST(LogGuess, RecordedLogs) {
  PISTE_REQUIRE_DATASETS();
  const auto guess = [](const char* name) {
    return guess_log(name, test::read_text(test::datasets() / "drive" / name));
  };
  EXPECT_EQ(guess("imu.txt").kind, LogKind::kImu);
  EXPECT_EQ(guess("gnss.txt").kind, LogKind::kGnss);
  EXPECT_EQ(guess("gnss_full.txt").kind, LogKind::kGnss);
  EXPECT_EQ(guess("gnss_1934_sf.pos").format, LogFormat::kRtklibPos);
}

}  // namespace
}  // namespace piste
