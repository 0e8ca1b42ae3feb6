// What inspect guesses of the layouts that loggers in wide use write.

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <string>
#include <vector>

#include "piste/columns/log_guess.h"
#include "piste/core/error.h"
#include "piste/io/log_io.h"
#include "support/random.h"
#include "support/text_file.h"

namespace piste {
namespace {

using test::contains;

constexpr int kSamples = 1500;  // of an IMU at 100 Hz

struct Sample {
  double t;
  Vector3d gyro, accel;  // rad/s, m/s²

  std::string turns(double unit = 1, const char* format = "{:.5f},{:.5f},{:.5f}") const {
    return fmt::format(fmt::runtime(format), gyro.x() / unit, gyro.y() / unit, gyro.z() / unit);
  }
  std::string forces(double unit = 1, const char* format = "{:.5f},{:.5f},{:.5f}") const {
    return fmt::format(fmt::runtime(format), accel.x() / unit, accel.y() / unit, accel.z() / unit);
  }
};

std::vector<Sample> samples() {
  std::vector<Sample> all;
  test::Random random(7);
  const auto next = [&] { return random.uniform() - 0.5; };
  for (int i = 0; i < kSamples; ++i) {
    const double t = 0.01 * i, turn = i < 500 ? 0 : 0.8 * std::sin(t);
    all.push_back({t, Vector3d(0.1 * turn, -0.2 * turn, turn) + 0.01 * Vector3d(next(), next(), next()),
                   Vector3d(0.3, 0.5, 9.79) + 0.1 * Vector3d(next(), next(), next())});
  }
  return all;
}

std::string imu_rows(const std::string& head, const std::function<std::string(int, const Sample&)>& row) {
  std::string text = head;
  int i = 0;
  for (const Sample& s : samples()) text += row(i++, s) + "\n";
  return text;
}

// Latitude and longitude of the fix number i.
std::string place(int i) { return fmt::format("46.1{:04},7.2{:04}", i, 2 * i); }

std::string fix_rows(const std::string& head, const std::function<std::string(int)>& row) {
  std::string text = head;
  for (int i = 0; i < 40; ++i) text += row(i) + "\n";
  return text;
}

std::string mapping(const LogGuess& guess) { return guess.columns ? columns_text(*guess.columns, "") : ""; }

// What is guessed of a text, once the reader has read it so: without a fault, and some rows of each log.
LogGuess tried(const std::string& file, const std::string& text) {
  const LogGuess first = guess_log(file, text);
  std::vector<LogGuess> all = first.beside;
  all.push_back(first);
  for (const LogGuess& guess : all) {
    if (guess.part != LogGuess::Part::kWhole || !guess.columns) continue;  // parts need each other
    LogFile log;
    log.file = file;
    log.content = text;
    log.format = guess.format;
    log.columns = guess.columns;
    log.shared_stamps = contains(mapping(guess), "DateTime") || contains(text, "timestamp,gx");
    log.sigma = Vector3d(3, 3, 6);
    log.sigma_velocity = Vector3d::Constant(0.5);
    RowFaults faults;
    const std::size_t rows =
        guess.kind == LogKind::kImu ? read_imu(log, &faults).time.size() : read_gnss(log, &faults).fixes.size();
    EXPECT_GT(rows, 20U) << file << "\n" << mapping(guess);
    EXPECT_EQ(faults.total(), 0U) << (faults.first.empty() ? "" : faults.first[0].what);
  }
  return first;
}

void expect_has(const LogGuess& guess, const std::vector<std::string>& parts) {
  for (const std::string& part : parts)
    EXPECT_TRUE(contains(mapping(guess), part)) << part << "\nis not in\n" << mapping(guess);
}

// ---- Rows of several sensors ----

TEST(LoggerDialects, MergedTablesWithBlanks) {
  const LogGuess imu =
      tried("all.csv", imu_rows("t,gyro_x,gyro_y,gyro_z,acc_x,acc_y,acc_z,lat,lon,alt\n", [](int i, const Sample& s) {
              const std::string row = fmt::format("{:.3f},{},{},,,", s.t, s.turns(), s.forces());
              return i % 20 == 0 ? fmt::format("{}\n{:.4f},,,,,,,{},400.{}", row, s.t + 0.003, place(i), i % 7) : row;
            }));
  EXPECT_EQ(imu.kind, LogKind::kImu);
  ASSERT_EQ(imu.beside.size(), 1U);
  EXPECT_EQ(imu.beside[0].kind, LogKind::kGnss);
  expect_has(imu.beside[0], {"latitude: {name: lat, unit: deg}", "only_new: true"});
}

TEST(LoggerDialects, GyroscopesAndAccelerometersInRowsOfTheirOwn) {
  const LogGuess gyro =
      tried("all.csv", imu_rows("t,gx,gy,gz,ax,ay,az\n", [](int, const Sample& s) {
              return fmt::format("{:.4f},{},,,\n{:.4f},,,,{}", s.t, s.turns(), s.t + 0.004, s.forces());
            }));
  EXPECT_EQ(gyro.part, LogGuess::Part::kGyro);
  ASSERT_EQ(gyro.beside.size(), 1U);
  EXPECT_EQ(gyro.beside[0].part, LogGuess::Part::kAccel);
}

// As the Google smartphone challenge has them.
TEST(LoggerDialects, AColumnSaysOfWhichSensorARowIs) {
  const LogGuess gyro = tried(
      "device_imu.csv",
      imu_rows("MessageType,utcTimeMillis,MeasurementX,MeasurementY,MeasurementZ,BiasX\n", [](int i, const Sample& s) {
        return fmt::format("UncalAccel,{},{},0\nUncalGyro,{},{},0\nUncalMag,{},20,3,-40,1", 1700000000001 + 10 * i,
                           s.forces(), 1700000000003 + 10 * i, s.turns(), 1700000000005 + 10 * i);
      }));
  std::vector<LogGuess> all = gyro.beside;
  all.push_back(gyro);
  ASSERT_EQ(all.size(), 2U) << "the magnetometer is none";
  for (const LogGuess& guess : all) {
    const bool turns = guess.part == LogGuess::Part::kGyro;
    expect_has(guess, {turns ? "rows: {name: MessageType, is: UncalGyro}" : "rows: {name: MessageType, is: UncalAccel}",
                       turns ? "gyro: {names: [MeasurementX" : "accel: {names: [MeasurementX"});
  }
}

TEST(LoggerDialects, SeveralImusByTheirNumbers) {
  const LogGuess first =
      tried("IMU.csv", imu_rows("TimeUS,I,GyrX,GyrY,GyrZ,AccX,AccY,AccZ\n", [](int i, const Sample& s) {
              return fmt::format("{0},0,{1},{2}\n{0},1,{1},{2}", 57000000 + 10000 * i, s.turns(), s.forces());
            }));
  ASSERT_EQ(first.beside.size(), 1U);
  expect_has(first, {"rows: {name: I, is: 0}"});
  expect_has(first.beside[0], {"rows: {name: I, is: 1}"});
}

TEST(LoggerDialects, GnssLoggerNamesItsColumnsInComments) {
  const LogGuess first = tried(
      "gnss_log.txt",
      imu_rows(
          "# \n# Header Description:\n# \n"
          "# Fix,Provider,LatitudeDegrees,LongitudeDegrees,AltitudeMeters,SpeedMps,AccuracyMeters,BearingDegrees,"
          "UnixTimeMillis\n"
          "# UncalAccel,utcTimeMillis,elapsedRealtimeNanos,UncalAccelXMps2,UncalAccelYMps2,UncalAccelZMps2,BiasXMps2\n"
          "# UncalGyro,utcTimeMillis,elapsedRealtimeNanos,UncalGyroXRadPerSec,UncalGyroYRadPerSec,"
          "UncalGyroZRadPerSec,DriftXRadPerSec\n",
          [](int i, const Sample& s) {
            const long ms = 1700000000000 + 10L * i;
            std::string rows = fmt::format("UncalAccel,{0},{1}000000,{2},0\nUncalGyro,{0},{1}000000,{3},0", ms,
                                           ms % 1000000000, s.forces(), s.turns());
            if (i % 50 == 0) rows += fmt::format("\nFix,GPS,{},450.2,3.5,2.1,{}.5,{}", place(i), i % 300, ms);
            return rows;
          }));
  std::vector<LogGuess> all = first.beside;
  all.push_back(first);
  ASSERT_EQ(all.size(), 3U);
  for (const LogGuess& guess : all) {
    if (guess.kind == LogKind::kGnss) {
      expect_has(guess,
                 {"rows: {name: 1, is: Fix}", "time: {name: 9, unit: ms, of: utc}", "latitude: {name: 3, unit: deg}",
                  "speed: {name: 6, unit: 'm/s'}", "vertical_accuracy: {name: 7, unit: m}"});
    } else if (guess.part == LogGuess::Part::kGyro) {
      expect_has(guess, {"rows: {name: 1, is: UncalGyro}", "gyro: {names: [4, 5, 6], unit: 'rad/s'}"});
    } else {
      expect_has(guess, {"rows: {name: 1, is: UncalAccel}", "accel: {names: [4, 5, 6], unit: 'm/s^2'}"});
    }
  }
}

TEST(LoggerDialects, FlySight) {
  const LogGuess sensor = tried(
      "SENSOR.CSV", imu_rows("$FLYS,1\n$COL,BARO,time,pressure,temperature\n$UNIT,BARO,s,Pa,deg C\n"
                             "$COL,IMU,time,wx,wy,wz,ax,ay,az,temperature\n$UNIT,IMU,s,deg/s,deg/s,deg/s,g,g,g,deg "
                             "C\n$DATA\n",
                             [](int, const Sample& s) {
                               return fmt::format("$IMU,{0:.3f},{1},{2},28.1\n$BARO,{0:.3f},75012.1,28.0", s.t,
                                                  s.turns(M_PI / 180), s.forces(9.80665));
                             }));
  expect_has(sensor, {"time: {name: 2, unit: s, of: boot}", "rows: {name: 1, is: '$IMU'}",
                      "gyro: {names: [3, 4, 5], unit: 'deg/s'}", "accel: {names: [6, 7, 8], unit: g}"});
  const LogGuess track =
      tried("12-00-00.CSV",
            fix_rows("time,lat,lon,hMSL,velN,velE,velD,hAcc,vAcc,sAcc\n,(deg),(deg),(m),(m/s),(m/s),(m/s),(m),("
                     "m),(m/s)\n",
                     [](int i) {
                       return fmt::format("2025-08-20T11:59:{:02}.00Z,{},450.2,0.1,0.{},0.1,1,2,0.3", i, place(i), i);
                     }));
  expect_has(track, {"time: {name: time, unit: calendar, of: utc}", "latitude: {name: lat}", "height: {name: hMSL}",
                     "velocity: {names: [velN, velE, velD]}", "speed_accuracy: {name: sAcc}"});
}

// ---- Columns that their values refute ----

TEST(LoggerDialects, ACourseInRadiansByThePlaces) {
  const auto circle = [](double unit) {
    return fix_rows("t,lat,lon,alt,spd,crs\n", [&](int i) {
      const double angle = 0.2 * i;  // about a circle of 90 m, northwards first
      return fmt::format("{:.1f},{:.7f},{:.7f},450.2,9.0,{:.4f}", 2.0 * i, 46 + 8.1e-4 * std::sin(angle),
                         7 - 1.16e-3 * std::cos(angle), std::fmod(angle, 2 * M_PI) / unit);
    });
  };
  expect_has(tried("gps.csv", circle(1)), {"course: {name: crs, unit: rad}"});
  expect_has(tried("gps.csv", circle(M_PI / 180)), {"course: {name: crs, unit: deg}"});
}

TEST(LoggerDialects, ABarometersHeightIsNotTheReceivers) {
  const LogGuess imu =
      tried("all.csv",
            imu_rows("t,gyro_x,gyro_y,gyro_z,acc_x,acc_y,acc_z,bmp_alt,lat,lon,alt_gnss\n", [](int i, const Sample& s) {
              return fmt::format("{:.3f},{},{},{:.2f},{},400.{}", s.t, s.turns(), s.forces(), 12 + 0.01 * (i % 9),
                                 place(i / 25), i / 25 % 7);
            }));
  ASSERT_EQ(imu.beside.size(), 1U);
  expect_has(imu.beside[0], {"height: {name: alt_gnss, unit: m}"});
}

TEST(LoggerDialects, AColumnOfFixesThatLeavesOutEveryRowIsNone) {
  const auto with = [](int type) {
    return fix_rows("t,lat,lon,alt,fixType\n",
                    [&](int i) { return fmt::format("{}.5,{},450.2,{}", i, place(i), type); });
  };
  EXPECT_FALSE(contains(mapping(tried("gps.csv", with(1))), "fix:"));
  expect_has(tried("gps.csv", with(3)), {"fix: {name: fixType, valid: [2, 3, 4]}"});
}

TEST(LoggerDialects, AMagnetometerOfUnitLengthIsNoAccelerometer) {
  expect_has(tried("imu.txt", imu_rows("",
                                       [](int i, const Sample& s) {
                                         return fmt::format("{:.3f}\t{}\t{}\t0.6000\t{:.4f}\t0.7999", s.t,
                                                            s.forces(1, "{:.5f}\t{:.5f}\t{:.5f}"),
                                                            s.turns(1, "{:.5f}\t{:.5f}\t{:.5f}"), 1e-4 * (i % 5));
                                       })),
             {"accel: {names: [2, 3, 4], unit: 'm/s^2'}", "gyro: {names: [5, 6, 7], unit: 'rad/s'}"});
}

TEST(LoggerDialects, DaysAndSlowClocks) {
  expect_has(
      tried("gps.csv",
            fix_rows("time,lat,lon,alt\n",
                     [](int i) { return fmt::format("{:.9f},{},450.{}", 739000.25 + i / 86400.0, place(i), i % 5); })),
      {"time: {name: time, unit: datenum, of: utc}"});
  expect_has(
      tried("gps.csv",
            fix_rows("time,lat,lon,alt\n",
                     [](int i) { return fmt::format("{:.9f},{},450.{}", 45300.25 + i / 86400.0, place(i), i % 5); })),
      {"time: {name: time, unit: sheet_days, of: utc}"});
  expect_has(tried("imu.csv", imu_rows("time,gx,gy,gz,ax,ay,az\n",
                                       [](int i, const Sample& s) {
                                         return fmt::format("{:.1f},{},{}", 0.5 * i, s.turns(), s.forces());
                                       })),
             {"time: {name: time, unit: s, of: boot}"});
}

TEST(LoggerDialects, StampsOfEachSensorAndTheirSigns) {
  const LogGuess imu =
      tried("all.csv",
            imu_rows("loggingTime,locationTimestamp_since1970,locationLatitude,locationLongitude,locationAltitude,"
                     "accelerometerTimestamp_sinceReboot,accelerometerAccelerationX,accelerometerAccelerationY,"
                     "accelerometerAccelerationZ,gyroTimestamp_sinceReboot,gyroRotationX,gyroRotationY,gyroRotationZ\n",
                     [](int i, const Sample& s) {
                       const std::string fix = i % 50 == 30 ? fmt::format("{}.{},{},450.{}", 1707307000 + i / 100,
                                                                          i % 100 / 10, place(i), i % 7)
                                                            : std::string(",,,");
                       const std::string turns = i % 9 == 4 ? ",,," : fmt::format("{:.3f},{}", 7000 + s.t, s.turns());
                       return fmt::format("2024-02-07 13:00:{:06.3f},{},{:.3f},{},{}", 10 + s.t, fix, 7000 + s.t,
                                          s.forces(9.80665), turns);
                     }));
  expect_has(imu, {"time: {name: gyroTimestamp_sinceReboot, unit: s, of: boot}", "axes: -x -y -z, unit: g"});
  ASSERT_EQ(imu.beside.size(), 1U);
  expect_has(imu.beside[0], {"time: {name: locationTimestamp_since1970, unit: s, of: utc}"});
  ASSERT_TRUE(imu.beside[0].boot_time);
  EXPECT_EQ(imu.beside[0].boot_time->name, "gyroTimestamp_sinceReboot");
}

// Of ArduPilot's older logs: TimeMS is of the GPS week, and T since power-up, as TimeMS of the IMU is.
TEST(LoggerDialects, ArduPilotsTwoTimes) {
  const LogGuess imu = tried(
      "00000001.log",
      imu_rows("FMT, 129, 31, IMU, Iffffff, TimeMS,GyrX,GyrY,GyrZ,AccX,AccY,AccZ\n"
               "FMT, 130, 45, GPS, BIHBcLLeeEefI, Status,TimeMS,Week,NSats,HDop,Lat,Lng,RelAlt,Alt,Spd,GCrs,VZ,T\n",
               [](int i, const Sample& s) {
                 const std::string row = fmt::format("IMU, {:.0f}, {}, {}", 1000 * s.t + 8000, s.turns(), s.forces());
                 return i % 20 == 5
                            ? fmt::format("{}\nGPS, 3, {:.0f}, 1800, 9, 1.2, {}, 3.1, 450.{}, 2.1, 30.5, 0.1, {:.0f}",
                                          row, 400000000 + 1000 * s.t, place(i), i % 7, 1000 * s.t + 8150)
                            : row;
               }));
  std::vector<LogGuess> all = imu.beside;
  all.push_back(imu);
  const auto gps = std::find_if(all.begin(), all.end(), [](const LogGuess& g) { return g.kind == LogKind::kGnss; });
  ASSERT_NE(gps, all.end());
  expect_has(*gps, {"time: {name: 3, week: 4, unit: ms, of: gps_week}"});
  ASSERT_TRUE(gps->boot_time);
  EXPECT_EQ(gps->boot_time->name, "14");
}

TEST(LoggerDialects, RowsThatTellTheClock) {
  const LogGuess sensor = tried(
      "SENSOR.CSV",
      imu_rows("$FLYS,1\n$COL,IMU,time,wx,wy,wz,ax,ay,az\n$UNIT,IMU,s,deg/s,deg/s,deg/s,g,g,g\n"
               "$COL,TIME,time,tow,week\n$UNIT,TIME,s,s,\n$DATA\n",
               [](int i, const Sample& s) {
                 const std::string row =
                     fmt::format("$IMU,{:.3f},{},{}", 100 + s.t, s.turns(M_PI / 180), s.forces(9.80665));
                 return i % 500 == 7 ? fmt::format("{}\n$TIME,{:.3f},{:.3f},2300", row, 100 + s.t, 5000.25 + s.t) : row;
               }));
  ASSERT_EQ(sensor.clock.size(), 3U);
  EXPECT_NEAR(sensor.clock[0].second - sensor.clock[0].first, 4900.25, 1e-6);
}

// ---- Headers ----

// Units below the names, and below these the sensors, as of RaceChrono.
TEST(LoggerDialects, LinesOfUnits) {
  const LogGuess imu = tried(
      "session.csv",
      imu_rows(
          "Format,3\nSession title,\"Test\"\n\n"
          "timestamp,lap,speed,x_acc,y_acc,z_acc,x_rate_of_rotation,y_rate_of_rotation,z_rate_of_rotation\n"
          "unix time,,m/s,G,G,G,deg/s,deg/s,deg/s\n,,calc,101: acc,101: acc,101: acc,102: gyro,102: gyro,102: gyro\n",
          [](int, const Sample& s) {
            return fmt::format("17000000{:05.2f},,3,{},{}", 10 + s.t, s.forces(9.80665), s.turns(M_PI / 180));
          }));
  expect_has(imu, {"time: {name: timestamp, unit: s, of: utc}",
                   "gyro: {names: [x_rate_of_rotation, y_rate_of_rotation, z_rate_of_rotation]}",
                   "accel: {names: [x_acc, y_acc, z_acc]}"});
}

TEST(LoggerDialects, AxesBeforeTheSensorAndBehindIt) {
  const auto row = [](int, const Sample& s) { return fmt::format("{:.3f},{},{}", s.t, s.forces(9.80665), s.turns()); };
  expect_has(tried("3dm.csv", imu_rows("GPS TOW,X Accel [x8004],Y Accel [x8004],Z Accel [x8004],X Gyro [x8005],Y "
                                       "Gyro [x8005],Z Gyro [x8005]\n",
                                       row)),
             {"gyro: {names: ['X Gyro', 'Y Gyro', 'Z Gyro'], unit: 'rad/s'}",
              "accel: {names: ['X Accel', 'Y Accel', 'Z Accel'], unit: g}"});
  expect_has(tried("shimmer.csv", imu_rows("S_B6_Time_CAL,S_Accel_LN_X_CAL,S_Accel_LN_Y_CAL,S_Accel_LN_Z_CAL,S_Gyro_X_"
                                           "CAL,S_Gyro_Y_CAL,S_Gyro_Z_CAL\ns,g,g,g,rad/s,rad/s,rad/s\n",
                                           row)),
             {"gyro: {names: [S_Gyro_X_CAL, S_Gyro_Y_CAL, S_Gyro_Z_CAL]}"});
}

TEST(LoggerDialects, GoProNamesOneAxisOfThree) {
  const LogGuess gyro =
      tried("gyro.csv", imu_rows("cts,date,Gyroscope [rad/s],1,2,temperature [°C]\n", [](int, const Sample& s) {
              return fmt::format("{:.3f},2025-08-20T11:59:{:06.3f}Z,{},44.1", 1000 * s.t, 10 + s.t, s.turns());
            }));
  EXPECT_EQ(gyro.part, LogGuess::Part::kGyro);
  expect_has(gyro, {"time: {name: date, unit: calendar, of: utc}", "gyro: {names: [Gyroscope, 1, 2], unit: 'rad/s'}"});
}

TEST(LoggerDialects, TheNameOfAFileWithoutHeader) {
  const LogGuess accel =
      tried("accelerometer.csv",
            imu_rows("", [](int, const Sample& s) { return fmt::format("{:.6f},{}", s.t, s.forces()); }));
  EXPECT_EQ(accel.part, LogGuess::Part::kAccel);
  expect_has(accel, {"accel: {names: [2, 3, 4], unit: 'm/s^2'}"});
  EXPECT_EQ(tried("gyro.txt", imu_rows("# Created at noon\n# timestamp x y z\n",
                                       [](int, const Sample& s) {
                                         return fmt::format("{:.0f} {}", 1e9 * (1849 + s.t),
                                                            s.turns(1, "{:.6f} {:.6f} {:.6f}"));
                                       }))
                .part,
            LogGuess::Part::kGyro);
}

// Columns that never change, such as numbers of sensors, are of no triad.
TEST(LoggerDialects, ConstantsBetweenTriadsWithoutHeader) {
  expect_has(tried("log.csv", imu_rows("",
                                       [](int, const Sample& s) {
                                         return fmt::format("{:.3f},3,{},4,{},5,11,-3,-41", s.t, s.forces(), s.turns());
                                       })),
             {"gyro: {names: [7, 8, 9]", "accel: {names: [3, 4, 5]"});
}

// Of NCLT in radians, of KAIST in degrees with a covariance, and as `ros2 topic echo --csv` writes them.
TEST(LoggerDialects, PlacesWithoutHeader) {
  const auto degrees = [](int i) { return fmt::format("46.09{:04},7.22{:04},{:.2f}", i, 2 * i, 450 + 0.1 * (i % 7)); };
  expect_has(tried("gps.csv", fix_rows("",
                                       [](int i) {
                                         return fmt::format("{},3,{},0.8045{:05},0.1261{:05},{:.2f},0.2,0.1",
                                                            1700000000000000 + 200000L * i, 8 + i % 3, i, 2 * i,
                                                            450 + 0.1 * (i % 7));
                                       })),
             {"time: {name: 1, unit: us, of: utc}", "latitude: {name: 4, unit: rad}", "height: {name: 6, unit: m}"});
  const LogGuess kaist = tried("gps.csv", fix_rows("", [&](int i) {
                                 return fmt::format("{},{},0.0004,0,0,0,0.0004,0,0,0,0.0016",
                                                    1700000000000000000 + 200000000L * i, degrees(i));
                               }));
  EXPECT_EQ(kaist.format, LogFormat::kColumns);
  expect_has(kaist,
             {"latitude: {name: 2, unit: deg}", "longitude: {name: 3, unit: deg}", "height: {name: 4, unit: m}"});
  expect_has(tried("fix.csv", fix_rows("",
                                       [&](int i) {
                                         return fmt::format("{},{},gps,0,1,{},4e-4,0.0", 1700000000 + i / 5,
                                                            200000000 * (i % 5), degrees(i));
                                       })),
             {"time: {name: 1, unit: s, rest: {name: 2, unit: ns}, of: utc}", "latitude: {name: 6, unit: deg}"});
}

// ---- Units and times ----

TEST(LoggerDialects, RawCountsOfBothTriads) {
  const LogGuess imu = tried("log.csv", imu_rows("millis,AcX,AcY,AcZ,GyX,GyY,GyZ\n", [](int i, const Sample& s) {
                               return fmt::format("{},{},{}", 10 * i, s.forces(9.80665 / 16384, "{:.0f},{:.0f},{:.0f}"),
                                                  s.turns(M_PI / 180 / 131, "{:.0f},{:.0f},{:.0f}"));
                             }));
  expect_has(imu, {"gyro: {names: [GyX, GyY, GyZ], unit: '0.00763359 deg/s'}"});
  EXPECT_TRUE(contains(imu.doubts.at(0) + imu.doubts.at(1), "gyro: counts"));
}

TEST(LoggerDialects, ForcesInTwoParts) {
  const LogGuess imu =
      tried("motion.csv", imu_rows("timestamp,gravityX,gravityY,gravityZ,userAccelerationX,userAccelerationY,"
                                   "userAccelerationZ,rotationRateX,rotationRateY,rotationRateZ\n",
                                   [](int, const Sample& s) {
                                     return fmt::format("{:.3f},0.03,0.05,0.998,0.01,0.0{},0.02,{}", s.t,
                                                        s.t > 5 ? 1 : 2, s.turns());
                                   }));
  expect_has(imu,
             {"accel: {names: [userAccelerationX, userAccelerationY, userAccelerationZ], added: [gravityX, gravityY, "
              "gravityZ], unit: g}"});
}

TEST(LoggerDialects, XsensWithoutARateHasTheSamplesOwnTime) {
  const auto with = [](const std::string& head, const char* ticks) {
    return tried("MT.txt", imu_rows(head + "PacketCounter,SampleTimeFine,Acc_X,Acc_Y,Acc_Z,Gyr_X,Gyr_Y,Gyr_Z\n",
                                    [&](int i, const Sample& s) {
                                      return fmt::format("{},{},{},{}", i, fmt::format(fmt::runtime(ticks), 3000 + i),
                                                         s.forces(), s.turns());
                                    }));
  };
  expect_has(with("// Device information:\n", "{}00"), {"time: {name: SampleTimeFine, unit: 1e-4 s, of: boot}"});
  expect_has(with("DeviceTag:,Xsens DOT 1\n", "{}0000"), {"time: {name: SampleTimeFine, unit: us, of: boot}"});
  EXPECT_EQ(with("// Update Rate: 100.0Hz\n", "{}00").format, LogFormat::kXsensAscii);
}

// The time that tells the rows apart, and of a log without one the coarse clock.
TEST(LoggerDialects, CoarseClocks) {
  const auto with = [](const std::string& names, const std::function<std::string(double)>& time) {
    return tried("log.csv", imu_rows(names + ",gx,gy,gz,ax,ay,az\n", [&](int, const Sample& s) {
                   return fmt::format("{},{},{}", time(s.t), s.turns(), s.forces());
                 }));
  };
  expect_has(
      with("DateTime,millis",
           [](double t) { return fmt::format("2025-08-20 11:59:{:02},{:.0f}", 10 + static_cast<int>(t), 1e3 * t); }),
      {"time: {name: millis, unit: ms, of: boot}"});
  expect_has(with("DateTime", [](double t) { return fmt::format("20/08/2025 11:59:{:02}", 10 + static_cast<int>(t)); }),
             {"time: {name: DateTime, unit: calendar, of: utc}"});
  expect_has(with("timestamp", [](double t) { return fmt::format("{}", 1700000000 + static_cast<int>(t)); }),
             {"time: {name: timestamp, unit: s, of: utc}"});
}

TEST(LoggerDialects, IntegersOfFitAndOfOthers) {
  expect_has(tried("activity.csv", fix_rows("timestamp,position_lat,position_long,enhanced_altitude,enhanced_speed\n",
                                            [](int i) {
                                              return fmt::format(
                                                  "2025-08-20 11:59:{:02}+00:00,5499622{:02},862403{:02},2478.8,{}.2",
                                                  i, i, i, i % 5);
                                            })),
             {"latitude: {name: position_lat, unit: '8.3819031715393066e-8 deg'}",
              "height: {name: enhanced_altitude, unit: m}"});
  expect_has(tried("track.csv", fix_rows("time,latitudeE7,longitudeE7,altitude\n",
                                         [](int i) {
                                           return fmt::format("{},4609730{:02},722859{:02},2480.25{}", 1700000000 + i,
                                                              i, i, i % 3);
                                         })),
             {"latitude: {name: latitudeE7, unit: '1e-7 deg'}", "height: {name: altitude, unit: m}"});
}

TEST(LoggerDialects, VelocityAndDirection) {
  expect_has(
      tried("Location.csv",
            fix_rows("\"Time (s)\",\"Latitude (°)\",\"Longitude (°)\",\"Height (m)\",\"Velocity "
                     "(m/s)\",\"Direction (°)\",\"Horizontal Accuracy (m)\"\n",
                     [](int i) { return fmt::format("{}.5,{},450.2,3.{},12{}.5,2.5", i, place(i), i, i % 10); })),
      {"speed: {name: Velocity}", "course: {name: Direction}", "horizontal_accuracy: {name: 'Horizontal Accuracy'}",
       "vertical_accuracy: {name: 'Horizontal Accuracy'}"});
}

TEST(LoggerDialects, ArraysOfPlaces) {
  expect_has(
      tried("GPS1_POS.csv",
            fix_rows("\"week\",\"timeOfWeekMs\",\"lla[0]\",\"lla[1]\",\"lla[2]\",\"hMSL\"\n",
                     [](int i) { return fmt::format("2380,{},{},450.2,400.1", 302400000 + 200 * i, place(i)); })),
      {"time: {name: timeOfWeekMs, week: week, unit: ms, of: gps_week}", "latitude: {name: 'lla[0]', unit: deg}",
       "height: {name: 'lla[2]', unit: m}"});
  expect_has(
      tried("PIMU.csv", imu_rows("\"time\",\"theta[0]\",\"theta[1]\",\"theta[2]\",\"vel[0]\",\"vel[1]\",\"vel[2]\"\n",
                                 [](int, const Sample& s) {
                                   return fmt::format("{:.3f},{},{}", s.t, s.turns(100), s.forces(100));
                                 })),
      {"dtheta: {names: ['theta[0]'", "dvel: {names: ['vel[0]'"});
}

TEST(LoggerDialects, ARefusalSaysWhichColumnsAreKnown) {
  const auto text =
      fix_rows("time,latitude,breite,altitude\n", [](int i) { return fmt::format("{},{},450.2", i, place(i)); });
  const std::string why = test::message_of<DataError>([&] { guess_log("log.csv", text); });
  EXPECT_TRUE(contains(why,
                       "these are known: `time` (time), `latitude` (latitude), `altitude` (height); and not: "
                       "`breite`"))
      << why;
}

// ---- Logs that say of their columns in ways of their own what they are ----

std::string gyroflow(const std::string& orientation, double turn, double force, const std::string& force_scale) {
  const std::string head = fmt::format(
      "GYROFLOW IMU LOG\nversion,1.3\nid,custom_logger\norientation,{}\nvendor,potatocam\ntscale,0.0001\ngscale,{}\n"
      "ascale,{}\nt,gx,gy,gz,ax,ay,az\n",
      orientation, turn, force_scale);
  return imu_rows(head, [&](int i, const Sample& s) {
    return fmt::format("{},{},{}", 100 * i, s.turns(turn, "{:.0f},{:.0f},{:.0f}"),
                       s.forces(force, "{:.0f},{:.0f},{:.0f}"));
  });
}

TEST(LoggerDialects, ScalesAndAxesOfGyroflow) {
  const LogGuess imu = tried("log.gcsv", gyroflow("YxZ", 0.00122173047, 9.80665 * 0.00048828125, "0.00048828125"));
  expect_has(imu, {"time: {name: t, unit: 0.0001 s, of: boot}",
                   "gyro: {names: [gx, gy, gz], axes: -y +x +z, unit: '0.00122173047 rad/s'}",
                   "accel: {names: [ax, ay, az], axes: -y +x +z, unit: '0.00048828125 g'}"});
  EXPECT_TRUE(imu.doubts.empty());
}

// The scale should be that of g.
TEST(LoggerDialects, GyroflowWithMetresForG) {
  expect_has(
      tried("log.gcsv", gyroflow("XYZ", 0.001, 0.00981, "0.00981")),
      {"gyro: {names: [gx, gy, gz], unit: '0.001 rad/s'}", "accel: {names: [ax, ay, az], unit: '0.00981 m/s^2'}"});
  EXPECT_TRUE(contains(mapping(tried("log.gcsv", gyroflow("XXZ", 0.001, 9.80665e-3, "0.001"))),
                       "gyro: {names: [gx, gy, gz], unit: '0.001 rad/s'}"))
      << "no orientation";
}

std::string vbox(const std::string& names, const std::function<std::string(int)>& row) {
  return fix_rows(
      "File created on 20/08/2025 @ 12:00:00\r\n\r\n[header]\r\nsatellites\r\nvelocity kmh\r\n\r\n"
      "[laptiming]\r\nStart +2766.1 -0433.7 +2766.2 -0433.8 \xAC Start / Finish\r\n\r\n"
      "[column names]\r\n" +
          names + "\r\n\r\n[data]\r\n",
      row);
}

TEST(LoggerDialects, PlacesOfVboxAreMinutesToTheWest) {
  const auto text = [](const char* format) {
    return vbox("sats time lat long velocity heading height vert-vel", [format](int i) {
      return fmt::format("018 0917{:05.2f} {} 017.287 040.12 +0450.25 +0.01", 10 + 0.1 * i,
                         fmt::format(fmt::runtime(format), i));
    });
  };
  const LogGuess minutes = tried("run.vbo", text("+02765.83{0:03} -00433.71{0:03}"));
  expect_has(minutes, {"time: {name: time, unit: hhmmss, of: boot}", "latitude: {name: lat, unit: arcmin}",
                       "longitude: {name: long, axes: west, unit: arcmin}", "speed: {name: velocity, unit: 'km/h'}",
                       "course: {name: heading, unit: deg}"});
  const LogGuess degrees = tried("run.vbo", text("46.09{0:03} 7.22{0:03}"));
  expect_has(degrees, {"latitude: {name: lat, unit: deg}", "longitude: {name: long, unit: deg}"});
}

TEST(LoggerDialects, VboxWithAnImu) {
  std::string text =
      vbox("sats time lat long velocity heading height yawrate x_accel y_accel pitchrate rollrate z_accel",
           [](int) { return std::string(); });
  int i = 0;
  for (const Sample& s : samples()) {
    text += fmt::format(
        "018 0917{:05.2f} +02765.83{:03} -00433.713 017.287 040.12 +0450.25 {:+.6E} {:+.6E} {:+.6E} {:+.6E} {:+.6E} "
        "{:+.6E}\r\n",
        10 + s.t, i++ / 10, s.gyro.z() * 180 / M_PI, s.accel.x() / 9.80665, s.accel.y() / 9.80665,
        s.gyro.y() * 180 / M_PI, s.gyro.x() * 180 / M_PI, s.accel.z() / 9.80665);
  }
  const LogGuess imu = tried("run.vbo", text);
  expect_has(imu, {"gyro: {names: [rollrate, pitchrate, yawrate], unit: 'deg/s'}",
                   "accel: {names: [x_accel, y_accel, z_accel], unit: g}"});
  ASSERT_EQ(imu.beside.size(), 1U);
  expect_has(imu.beside[0], {"only_new: true", "longitude: {name: long, axes: west, unit: arcmin}"});
}

// ---- What is not what it seems ----

TEST(LoggerDialects, NamesThatAreLikeOthers) {
  const auto has = [](const std::string& header, const std::string& more, const std::string& key) {
    const LogGuess guess = guess_log("log.csv", fix_rows(header, [&](int i) {
                                       return fmt::format("{},{},450.2,{}", 1700000000 + i, place(i), more);
                                     }));
    return guess.columns->find(key) != nullptr;
  };
  EXPECT_FALSE(has("time,lat,lon,alt,wind_speed,wind_direction\n", "3.5,120.5", "speed"));
  EXPECT_FALSE(has("time,lat,lon,alt,theta_x,theta_y,theta_z,vel_x,vel_y,vel_z\n", "1,2,3,4,5,6", "dtheta"));
  const LogGuess satellites = guess_log("log.csv", fix_rows("time,elevation_deg,lat,lon,alt\n", [](int i) {
                                          return fmt::format("{},45.5,{},450.2", 1700000000 + i, place(i));
                                        }));
  expect_has(satellites, {"height: {name: alt, unit: m}"});
}

TEST(LoggerDialects, AColumnThatIsCalledAsAComment) {
  expect_has(tried("log.csv", imu_rows("#,time_ms,gx,gy,gz,ax,ay,az\n",
                                       [](int i, const Sample& s) {
                                         return fmt::format("{},{},{},{}", i, 10 * i, s.turns(), s.forces());
                                       })),
             {"gyro: {names: [gx, gy, gz]", "accel: {names: [ax, ay, az]"});
}

// A status of the solution is none of sensors.
TEST(LoggerDialects, TextsThatTellNoSensorsApart) {
  const LogGuess guess =
      tried("gps.csv", fix_rows("time,lat,lon,alt,mode\n", [](int i) {
              return fmt::format("{},{},450.2,{}", 1700000000 + i, place(i), i % 3 ? "GNSS" : "GNSS+IMU");
            }));
  EXPECT_TRUE(guess.beside.empty());
  EXPECT_TRUE(guess.columns->rows.empty());
}

// Beyond the first bytes of the file, and numbered: as of ArduPilot's text.
TEST(LoggerDialects, TaggedRowsThatBeginLate) {
  std::string text = "FMT, 129, 23, IMU, QBffffff, TimeUS,I,GyrX,GyrY,GyrZ,AccX,AccY,AccZ\n";
  for (int i = 0; i < 6000; ++i) text += fmt::format("PARM, {}, NAME_{}, {}\n", 1000 + i, i, 0.5 * i);
  test::Random random(3);
  text += imu_rows("", [&](int i, const Sample& s) {
    const Vector3d other = s.gyro + 1e-3 * random.vector();
    return fmt::format("IMU, {0}, 0, {1}, {2}\nIMU, {0}, 1, {3:.5f},{4:.5f},{5:.5f}, {2}", 57000000 + 10000 * i,
                       s.turns(), s.forces(), other.x(), other.y(), other.z());
  });
  const LogGuess first = tried("00000012.log", text);
  ASSERT_EQ(first.beside.size(), 1U);
  expect_has(first, {"rows: [{name: 1, is: IMU}, {name: 3, is: 0}]"});
  expect_has(first.beside[0], {"rows: [{name: 1, is: IMU}, {name: 3, is: 1}]"});
}

// Angles of a fusion beside the triads change slowly, too.
TEST(LoggerDialects, AnImuWithAnglesHasNoPlaces) {
  const LogGuess guess = guess_log("log.txt", imu_rows("", [](int, const Sample& s) {
                                     return fmt::format("{:.3f},{},{},{:.5f},{:.5f},{:.5f}", s.t, s.turns(), s.forces(),
                                                        12.5 + 1e-5 * s.t, -3.25 + 1e-5 * s.t, 80.1 + 1e-4 * s.t);
                                   }));
  EXPECT_EQ(guess.kind, LogKind::kImu);
}

}  // namespace
}  // namespace piste
