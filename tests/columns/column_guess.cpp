// What inspect guesses of tables that no other reader knows.

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <string>
#include <tuple>

#include "piste/columns/log_guess.h"
#include "piste/inspect/inspection.h"
#include "support/datasets.h"
#include "support/random.h"
#include "support/text_file.h"

namespace piste {
namespace {

using test::contains;

/// Rows of an IMU that rests and then turns, as `row(t, gyro [rad/s], accel [m/s²])` writes them.
std::string table(const std::string& header,
                  const std::function<std::string(double, const Vector3d&, const Vector3d&)>& row) {
  std::string text = header;
  test::Random random(1);
  const auto next = [&] { return random.uniform() - 0.5; };
  for (int i = 0; i < 2000; ++i) {
    const double t = 0.01 * i, turn = i < 600 ? 0 : 0.8 * std::sin(t);
    const Vector3d gyro = Vector3d(0.1 * turn, -0.2 * turn, turn) + 0.01 * Vector3d(next(), next(), next());
    const Vector3d accel = Vector3d(0.3, 0.5, 9.79) + 0.1 * Vector3d(next(), next(), next());
    text += row(t, gyro, accel);
  }
  return text;
}

std::string joined(const Vector3d& v, char separator = ',') {
  return fmt::format("{:.6f}{}{:.6f}{}{:.6f}", v.x(), separator, v.y(), separator, v.z());
}

std::string mapping(const std::string& file, const std::string& text) {
  const LogGuess guess = guess_log(file, text);
  EXPECT_EQ(guess.format, LogFormat::kColumns);
  return guess.columns ? columns_text(*guess.columns, "") : "";
}

TEST(ColumnGuess, PhyphoxInOneFile) {
  const auto text = table(
      "\"Time (s)\",\"Gyroscope x (rad/s)\",\"Gyroscope y (rad/s)\",\"Gyroscope z (rad/s)\",\"Acceleration x (m/s^2)\","
      "\"Acceleration y (m/s^2)\",\"Acceleration z (m/s^2)\"\n",
      [](double t, const Vector3d& w, const Vector3d& f) {
        return fmt::format("{:.4E},{},{}\n", t, joined(w), joined(f));
      });
  EXPECT_EQ(mapping("log.csv", text),
            "{time: {name: Time, of: boot},\n"
            "gyro: {names: ['Gyroscope x', 'Gyroscope y', 'Gyroscope z']},\n"
            "accel: {names: ['Acceleration x', 'Acceleration y', 'Acceleration z']}}");
}

// Its columns are x, y and z in each file; the name of the file tells which.
TEST(ColumnGuess, AndroidSensorLogger) {
  const auto write = [](bool gyro) {
    return table("time,seconds_elapsed,z,y,x\n", [gyro](double t, const Vector3d& w, const Vector3d& f) {
      const Vector3d& v = gyro ? w : f;
      return fmt::format("{}{:09.0f},{:.4f},{:.5f},{:.5f},{:.5f}\n", 1700000000 + static_cast<long>(t),
                         1e9 * (t - std::floor(t)), t, v.z(), v.y(), v.x());
    });
  };
  const LogGuess gyro = guess_log("Gyroscope.csv", write(true));
  EXPECT_EQ(gyro.part, LogGuess::Part::kGyro);
  EXPECT_EQ(columns_text(*gyro.columns, ""),
            "{time: {name: time, unit: ns, of: utc},\ngyro: {names: [x, y, z], unit: 'rad/s'}}");
  const LogGuess accel = guess_log("TotalAcceleration.csv", write(false));
  EXPECT_EQ(accel.part, LogGuess::Part::kAccel);
  EXPECT_EQ(accel.columns->find("accel")->unit, "m/s^2");
}

TEST(ColumnGuess, SensorLogOfIos) {
  const auto text = table(
      "loggingTime(txt),motionTimestamp_sinceReboot(s),motionUserAccelerationX(G),motionUserAccelerationY(G),"
      "motionUserAccelerationZ(G),motionRotationRateX(rad/s),motionRotationRateY(rad/s),motionRotationRateZ(rad/s),"
      "accelerometerAccelerationX(G),accelerometerAccelerationY(G),accelerometerAccelerationZ(G)\n",
      [](double t, const Vector3d& w, const Vector3d& f) {
        return fmt::format("2020-11-04 09:17:31.4 +0100,{:.4f},0.01,0.02,0.0,{},{}\n", 5000 + t, joined(w),
                           joined(f / 9.80665));
      });
  const std::string found = mapping("log.csv", text);
  EXPECT_TRUE(contains(found, "motionTimestamp_sinceReboot, of: boot")) << found;
  EXPECT_TRUE(contains(found, "gyro: {names: [motionRotationRateX, ")) << found;
  EXPECT_TRUE(contains(found, "accel: {names: [accelerometerAccelerationX, ")) << found;
}

TEST(ColumnGuess, Euroc) {
  const auto text = table(
      "#timestamp [ns],w_RS_S_x [rad s^-1],w_RS_S_y [rad s^-1],w_RS_S_z [rad s^-1],a_RS_S_x [m s^-2],a_RS_S_y [m "
      "s^-2],a_RS_S_z [m s^-2]\n",
      [](double t, const Vector3d& w, const Vector3d& f) {
        return fmt::format("{:.0f},{},{}\n", 1403636579.0e9 + 1e9 * t, joined(w), joined(f));
      });
  EXPECT_EQ(mapping("data.csv", text),
            "{time: {name: timestamp, of: utc},\ngyro: {names: [w_RS_S_x, w_RS_S_y, w_RS_S_z]},\n"
            "accel: {names: [a_RS_S_x, a_RS_S_y, a_RS_S_z]}}");
}

// As KAIST's: ns, a quaternion, angles, rates, forces, a magnetic field; no header.
TEST(ColumnGuess, ValuesAloneTellTheTriads) {
  const auto text = table("", [](double t, const Vector3d& w, const Vector3d& f) {
    return fmt::format("{:.0f},0.6,0.8,0,0,0.1,0.2,{:.4f},{},{},0.21,0.02,-0.43\n", 1.5e18 + 1e9 * t, t / 10, joined(w),
                       joined(f));
  });
  EXPECT_EQ(mapping("xsens_imu.csv", text),
            "{time: {name: 1, unit: ns, of: utc},\ngyro: {names: [9, 10, 11], unit: 'rad/s'},\n"
            "accel: {names: [12, 13, 14], unit: 'm/s^2'}}");
}

// Seven numbers as KF-GINS has them, but rates.
TEST(ColumnGuess, RatesAreNotTakenForIncrements) {
  const auto with = [](double factor) {
    return table("", [factor](double t, const Vector3d& w, const Vector3d& f) {
      return fmt::format("{:.3f} {} {}\n", 1000 + t, joined(factor * w, ' '), joined(factor * f, ' '));
    });
  };
  EXPECT_EQ(guess_log("imu.txt", with(0.01)).format, LogFormat::kKfGins);
  EXPECT_EQ(mapping("imu.txt", with(1)),
            "{time: {name: 1, unit: s, of: boot},\ngyro: {names: [2, 3, 4], unit: 'rad/s'},\n"
            "accel: {names: [5, 6, 7], unit: 'm/s^2'}}");
}

TEST(ColumnGuess, UnitsByTheValues) {
  const auto with = [](double gyro, double accel, double time) {
    return mapping("log", table("t,gx,gy,gz,ax,ay,az\n", [&](double t, const Vector3d& w, const Vector3d& f) {
                     return fmt::format("{:.5f},{},{}\n", (10 + t) * time, joined(gyro * w), joined(accel * f));
                   }));
  };
  EXPECT_TRUE(contains(
      with(1, 1, 1),
      "unit: s, of: boot},\ngyro: {names: [gx, gy, gz], unit: 'rad/s'},\naccel: {names: [ax, ay, az], unit: 'm/s^2'}"));
  EXPECT_TRUE(contains(
      with(kDegreesPerRadian, 1 / 9.80665, 1e3),
      "unit: ms, of: boot},\ngyro: {names: [gx, gy, gz], unit: 'deg/s'},\naccel: {names: [ax, ay, az], unit: g}"));
  EXPECT_TRUE(contains(with(1, 1e3 / 9.80665, 1e6), "unit: mg}"));
  EXPECT_TRUE(contains(with(1, 16384 / 9.80665, 1e6), "unit: us"));
  EXPECT_TRUE(contains(with(1, 16384 / 9.80665, 1e6), " g'}")) << "counts, with a number before the unit";
}

std::string receiver(const std::string& header, const std::function<std::string(int)>& row) {
  std::string text = header;
  for (int i = 0; i < 60; ++i) text += row(i);
  return text;
}

TEST(ColumnGuess, IntegersOfUblox) {
  const auto text =
      receiver("iTOW,lon,lat,height,hMSL,hAcc,vAcc,velN,velE,velD,gSpeed,headMot,sAcc,headAcc,fixType\n", [](int i) {
        return fmt::format("{},72500000,{},1600000,1550000,2000,3000,1000,20,3,1000,1145000,150,200000,3\n", 1000 * i,
                           465000000 + 90 * i);
      });
  const LogGuess guess = guess_log("nav_pvt.csv", text);
  EXPECT_EQ(guess.kind, LogKind::kGnss);
  const std::string found = columns_text(*guess.columns, "");
  EXPECT_TRUE(contains(found, "time: {name: iTOW, unit: ms, of: gps_week}")) << found;
  EXPECT_TRUE(contains(found, "latitude: {name: lat, unit: '1e-7 deg'}")) << found;
  EXPECT_TRUE(contains(found, "height: {name: height, unit: mm}")) << found;
  EXPECT_TRUE(contains(found, "velocity: {names: [velN, velE, velD], unit: 'mm/s'}")) << found;
  EXPECT_TRUE(contains(found, "speed_accuracy: {name: sAcc, unit: 'mm/s'}")) << found;
  EXPECT_TRUE(contains(found, "fix: {name: fixType, valid: [2, 3, 4]}")) << found;
  EXPECT_FALSE(guess.doubts.empty());
}

TEST(ColumnGuess, PhonesReceiverHasTwoTimes) {
  const auto text = receiver(
      "TimestampGNSS [ns]; UTC time [ms]; Lat [deg]; Lon [deg]; Height [m]; Speed [m/s]; Heading [deg]; Hor Acc [m]; "
      "Vert "
      "Acc [m]; Speed Acc [m/s]; Heading Acc [deg]\n",
      [](int i) {
        return fmt::format("{};{};48.9;9.1;360;1;90;3;100;20;10;\n", 473997216885851 + i * 1000000000L,
                           1604477851437 + 1000L * i);
      });
  const LogGuess guess = guess_log("GNSS.csv", text);
  EXPECT_EQ(guess.columns->time.name, "UTC time");
  EXPECT_EQ(guess.columns->time.of, TimeScale::kUtc);
  ASSERT_TRUE(guess.boot_time);
  EXPECT_EQ(guess.boot_time->name, "TimestampGNSS");
  EXPECT_NE(guess.columns->find("course_accuracy"), nullptr);
}

TEST(ColumnGuess, CalendarTimes) {
  const auto text = receiver("UTC;Latitude;Longitude;Altitude\n",
                             [](int i) { return fmt::format("2020-11-04 08:17:{:02d}.0;48.9;9.1;360\n", i); });
  EXPECT_TRUE(contains(mapping("places.txt", text), "{time: {name: UTC, unit: calendar, of: utc},"));
}

TEST(ColumnGuess, Angles) {
  const auto text =
      receiver("time_ms,roll,pitch,yaw\n", [](int i) { return fmt::format("{},1.5,-3,{}\n", 10 * i, 170 + 0.1 * i); });
  const LogGuess guess = guess_log("ahrs.csv", text);
  EXPECT_EQ(guess.kind, LogKind::kAttitude);
  EXPECT_EQ(columns_text(*guess.columns, ""),
            "{time: {name: time_ms, unit: ms, of: boot},\nangles: {names: [roll, pitch, yaw], unit: deg}}");
}

// ---- Times without a unit ----

// Of an IMU at 50 Hz: the same digits may be a time since 1970 in one unit, and since power-up in the next smaller one.
TEST(ColumnGuess, TimesSincePowerUpAreNotTakenForThoseSince1970) {
  const auto with = [](double first, double per_second) {
    const std::string found =
        mapping("log", table("timestamp,gx,gy,gz,ax,ay,az\n", [&](double t, const Vector3d& w, const Vector3d& f) {
                  return fmt::format("{:.0f},{},{}\n", first + 2 * t * per_second, joined(w), joined(f));
                }));
    return found.substr(0, found.find('\n'));
  };
  EXPECT_EQ(with(1200e6, 1e6), "{time: {name: timestamp, unit: us, of: boot},") << "20 minutes";
  EXPECT_EQ(with(1.5e15, 1e9), "{time: {name: timestamp, unit: ns, of: boot},") << "17 days";
  EXPECT_EQ(with(2e9, 1e9), "{time: {name: timestamp, unit: ns, of: boot},") << "two seconds";
  EXPECT_EQ(with(1.7e15, 1e6), "{time: {name: timestamp, unit: us, of: utc},");
  EXPECT_EQ(with(1.7e18, 1e9), "{time: {name: timestamp, unit: ns, of: utc},");
}

TEST(ColumnGuess, ReceiversOfHalfAMinuteAndOfTenHertz) {
  const auto with = [](double first, double step) {
    const std::string found = mapping("log", receiver("time,lat,lon,alt\n", [&](int i) {
                                        return fmt::format("{:.0f},46.5,6.{},400\n", first + i * step, 600 + i);
                                      }));
    return found.substr(0, found.find('\n'));
  };
  EXPECT_EQ(with(1.7e9, 30), "{time: {name: time, unit: s, of: utc},");
  EXPECT_EQ(with(1.5e15, 1e8), "{time: {name: time, unit: ns, of: boot},");
}

TEST(ColumnGuess, SecondsAndPartsOfThemInTwoColumns) {
  const auto with = [](const std::string& names, double per_second) {
    return table(names + ",gx,gy,gz,ax,ay,az\n", [&](double t, const Vector3d& w, const Vector3d& f) {
      return fmt::format("{},{:.0f},{},{}\n", 1700000000 + static_cast<long>(t + 1e-6),
                         (t + 1e-6 - std::floor(t + 1e-6)) * per_second, joined(w), joined(f));
    });
  };
  for (const auto& [seconds, rest, unit, per_second] :
       {std::tuple{"header.stamp.sec", "header.stamp.nanosec", "ns", 1e9},
        {"secs", "nsecs", "ns", 1e9},
        {"time_s", "time_us", "us", 1e6}}) {
    const std::string found = mapping("imu.csv", with(fmt::format("{},{}", seconds, rest), per_second));
    const std::string expected =
        fmt::format("{{time: {{name: {}, unit: s, rest: {{name: {}, unit: {}}}, of: utc}},\n", seconds, rest, unit);
    EXPECT_TRUE(found.starts_with(expected)) << found;
  }
  EXPECT_TRUE(contains(test::message_of<DataError>([&] { guess_log("imu.csv", with("message,time_ns", 1e9)); }),
                       "column `time_ns` keeps falling back"));
}

TEST(ColumnGuess, DecimalCommas) {
  const auto with = [](const std::string& header) {
    std::string text = table("", [](double t, const Vector3d& w, const Vector3d& f) {
      return fmt::format("{:.3f};{};{}\n", 1000 + t, joined(w, ';'), joined(f, ';'));
    });
    std::replace(text.begin(), text.end(), '.', ',');
    return header + text;
  };
  EXPECT_TRUE(
      contains(mapping("imu.csv", with("time;gx;gy;gz;ax;ay;az\n")), "accel: {names: [ax, ay, az], unit: 'm/s^2'}"));
  EXPECT_TRUE(contains(mapping("imu.csv", with("")), "accel: {names: [5, 6, 7], unit: 'm/s^2'}"));
}

// ---- Units that names state ----

TEST(ColumnGuess, UnitsAtTheEndOfNames) {
  const std::string found =
      mapping("fixes.csv", receiver("gps_time_s,lat_rad,lon_rad,alt_ft,speed_kn,course_rad,h_acc_cm\n", [](int i) {
                return fmt::format("{},0.81157,0.11519{},1312.99,12.5,0.3,40\n", 400000 + i, i);
              }));
  EXPECT_TRUE(contains(found, "latitude: {name: lat_rad, unit: rad}")) << found;
  EXPECT_TRUE(contains(found, "longitude: {name: lon_rad, unit: rad}")) << found;
  EXPECT_TRUE(contains(found, "height: {name: alt_ft, unit: '0.3048 m'}")) << found;
  EXPECT_TRUE(contains(found, "speed: {name: speed_kn, unit: kn}")) << found;
  EXPECT_TRUE(contains(found, "course: {name: course_rad, unit: rad}")) << found;
}

TEST(ColumnGuess, UnitsInBracketsAsTheyAreSpoken) {
  const std::string found =
      mapping("fixes.csv", receiver("time (s),lat,lon,Altitude (ft),Speed (mph),Course\n",
                                    [](int i) { return fmt::format("{},46.5,6.{},1312.99,12.5,90\n", i, 600 + i); }));
  EXPECT_TRUE(contains(found, "height: {name: Altitude, unit: '0.3048 m'}")) << found;
  EXPECT_TRUE(contains(found, "speed: {name: Speed, unit: '0.44704 m/s'}")) << found;
}

TEST(ColumnGuess, UnitsOfAnImuAtTheEndOfNames) {
  const auto text = table("t_s,gyro_x_deg_s,gyro_y_deg_s,gyro_z_deg_s,acc_x_m_s2,acc_y_m_s2,acc_z_m_s2\n",
                          [](double t, const Vector3d& w, const Vector3d& f) {
                            return fmt::format("{:.3f},{},{}\n", t, joined(w), joined(f));
                          });
  const std::string found = mapping("imu.txt", text);
  EXPECT_TRUE(contains(found, "gyro_z_deg_s], unit: 'deg/s'}")) << found;
  EXPECT_TRUE(contains(found, "acc_z_m_s2], unit: 'm/s^2'}")) << found;
}

TEST(ColumnGuess, TheHeightAboveTheEllipsoidIsTaken) {
  for (const std::string name : {"alt_ellipsoid", "hae", "ellipsoidal_height", "altitude_wgs84"}) {
    const std::string found = mapping("fixes.csv", receiver("time,lat,lon,alt," + name + "\n", [](int i) {
                                        return fmt::format("{},46.5,6.{},350,400\n", i, 600 + i);
                                      }));
    EXPECT_TRUE(contains(found, "height: {name: " + name + ", unit: m}")) << found;
  }
}

// ---- Places and times as loggers write them ----

TEST(ColumnGuess, PlacesWithoutASign) {
  const std::string found =
      mapping("fixes.csv", receiver("tow,lat,N/S,lon,E/W,alt_msl,geoid_sep\n", [](int i) {
                return fmt::format("{},46{:08.5f},S,00{:08.5f},W,450.1,50.2\n", 1000 + i, 5.8 + i * 0.01, 713.7);
              }));
  EXPECT_TRUE(contains(found, "latitude: {name: lat, hemisphere: 'N/S', unit: ddmm}")) << found;
  EXPECT_TRUE(contains(found, "longitude: {name: lon, hemisphere: 'E/W', unit: ddmm}")) << found;
  EXPECT_TRUE(contains(found, "height: {name: alt_msl, geoid: geoid_sep, unit: m}")) << found;
}

TEST(ColumnGuess, PlacesInRadians) {
  const std::string found = mapping("fixes.csv", receiver("tow,lat,lon,h\n", [](int i) {
                                      return fmt::format("{},0.81157,0.11519{},450.1\n", 1000 + i, i);
                                    }));
  EXPECT_TRUE(contains(found, "latitude: {name: lat, unit: rad}")) << found;
}

TEST(ColumnGuess, VelocitiesUpwards) {
  for (const std::string names :
       {"velocity_east,velocity_north,velocity_up", "vel_east,vel_north,vel_up", "ve,vn,vu"}) {
    const std::string found = mapping("fixes.csv", receiver("tow,lat,lon,h," + names + "\n", [](int i) {
                                        return fmt::format("{},46.5,6.{},450.1,1.5,2.5,0.1\n", 1000 + i, 600 + i);
                                      }));
    EXPECT_TRUE(contains(found, "axes: north east up")) << found;
  }
}

TEST(ColumnGuess, AccuraciesOfUbloxInSmallLetters) {
  const std::string found = mapping("fixes.csv", receiver("tow,lat,lon,h,hacc,vacc,sacc,vn,ve,vd\n", [](int i) {
                                      return fmt::format("{},46.5,6.{},450.1,0.5,0.8,0.1,1,2,3\n", 1000 + i, 600 + i);
                                    }));
  EXPECT_TRUE(contains(found, "horizontal_accuracy: {name: hacc, unit: m}")) << found;
  EXPECT_TRUE(contains(found, "vertical_accuracy: {name: vacc, unit: m}")) << found;
  EXPECT_TRUE(contains(found, "speed_accuracy: {name: sacc, unit: 'm/s'}")) << found;
}

// As a program writes UBX-NAV-PVT that has divided the angles alone.
TEST(ColumnGuess, MillimetresBesideDegrees) {
  const std::string found =
      mapping("fixes.csv", receiver("iTOW,lon,lat,height,hMSL,hAcc,vAcc,velN,velE,velD\n", [](int i) {
                return fmt::format("{},6.{},46.5,450100,400000,14,20,1000,2000,-30\n", 1000 * i, 600 + i);
              }));
  EXPECT_TRUE(contains(found, "height: {name: height, unit: mm}")) << found;
  EXPECT_TRUE(contains(found, "horizontal_accuracy: {name: hAcc, unit: mm}")) << found;
  EXPECT_TRUE(contains(found, "unit: 'mm/s'}")) << found;
}

TEST(ColumnGuess, AReceiversTimeMayBeOfUnix) {
  const auto of = [](const std::string& first) {
    return mapping("fixes.csv", receiver("gps_time,lat,lon,h\n", [&](int i) {
                     return fmt::format("{},46.5,6.{},450.1\n", fmt::format(fmt::runtime(first), i % 60), 600 + i);
                   }));
  };
  EXPECT_TRUE(contains(of("17557000{:02}"), "of: utc"));
  EXPECT_TRUE(contains(of("14397000{:02}"), "of: gps}"));
  EXPECT_TRUE(contains(of("2025-08-20T11:59:{:02}.000Z"), "unit: calendar, of: utc"));
  EXPECT_TRUE(contains(of("2025-08-20T11:59:{:02}.000"), "unit: calendar, of: gps"));
}

TEST(ColumnGuess, TimesOfDay) {
  const auto of = [](const std::string& header, const std::function<std::string(int)>& time) {
    return mapping("fixes.csv",
                   receiver(header, [&](int i) { return fmt::format("{},46.5,6.{},450.1\n", time(i), i); }));
  };
  const auto digits = [](int i) { return fmt::format("{}.00", i < 30 ? 115930 + i : 120000 + i - 30); };
  EXPECT_TRUE(contains(of("utc,lat,lon,h\n", digits), "time: {name: utc, unit: hhmmss, of: boot}"));
  EXPECT_TRUE(contains(of("utc,lat,lon,h\n", [](int i) { return fmt::format("11:{:02}:{:02}", i / 60, i % 60); }),
                       "unit: hhmmss, of: boot}"));
  EXPECT_TRUE(contains(of("time,lat,lon,h\n", [](int i) { return fmt::format("{}", 115900 + i); }), "unit: s"))
      << "seconds go beyond 59";
}

TEST(ColumnGuess, TimesOfManyNames) {
  for (const std::string name : {"ms", "millis", "time_ms"}) {
    const auto text =
        table(name + ",gyrox,gyroy,gyroz,accx,accy,accz\n", [](double t, const Vector3d& w, const Vector3d& f) {
          return fmt::format("{:.0f},{},{}\n", 1e3 * t + 64000, joined(w), joined(f));
        });
    EXPECT_TRUE(contains(mapping("imu.csv", text), "unit: ms, of: boot}")) << name;
  }
}

TEST(ColumnGuess, ACounterMayStartAgain) {
  const auto text = table("time_ms,gx,gy,gz,ax,ay,az\n", [](double t, const Vector3d& w, const Vector3d& f) {
    return fmt::format("{},{},{}\n", (static_cast<int>(std::lround(1e3 * t)) + 60000) % 65536, joined(w), joined(f));
  });
  EXPECT_TRUE(contains(mapping("imu.csv", text), "time: {name: time_ms, unit: ms, of: boot}"));
}

TEST(ColumnGuess, OfSeveralTriadsTheSensorsOwn) {
  const auto text = table(
      "t_s,gyro_bias_x,gyro_bias_y,gyro_bias_z,gyro_x,gyro_y,gyro_z,linear_acceleration_x,linear_acceleration_y,"
      "linear_acceleration_z,acceleration_x,acceleration_y,acceleration_z\n",
      [](double t, const Vector3d& w, const Vector3d& f) {
        const Vector3d linear = f - Vector3d(0.3, 0.5, 9.79);
        return fmt::format("{:.3f},0.1,0.2,0.3,{},{},{}\n", t, joined(w), joined(linear), joined(f));
      });
  const std::string found = mapping("imu.csv", text);
  EXPECT_TRUE(contains(found, "gyro: {names: [gyro_x, gyro_y, gyro_z]")) << found;
  EXPECT_TRUE(contains(found, "accel: {names: [acceleration_x, acceleration_y, acceleration_z]")) << found;
}

TEST(ColumnGuess, SaysWhichQuantityIsMissing) {
  const auto refusal = [](const std::string& header, const std::string& row) {
    try {
      guess_log("fixes.csv", receiver(header, [&](int) { return row; }));
    } catch (const Error& e) {
      return std::string(e.what());
    }
    return std::string();
  };
  EXPECT_TRUE(contains(refusal("time,lat,lon\n", "1000,46.5,6.5\n"), "none that is known for the height"));
  EXPECT_TRUE(contains(refusal("lat,lon,h\n", "46.5,6.5,400\n"), "none that is known for the time"));
}

// Rows before the first fix hold a time and nothing else.
TEST(ColumnGuess, TheHeaderStandsAboveEmptyRows) {
  const std::string found = mapping("fixes.csv", receiver("tow,lat,lon,h\n", [](int i) {
                                      return i < 20 ? fmt::format("{},,,\n", 1000 + i)
                                                    : fmt::format("{},46.5,6.{},450.1\n", 1000 + i, 600 + i);
                                    }));
  EXPECT_TRUE(contains(found, "latitude: {name: lat, unit: deg}")) << found;
}

// ---- Files of one sensor, and of several ----

TEST(ColumnGuess, XyzAreGyroscopesOnlyIfTheFileIsNamedSo) {
  const auto with = [](const std::string& file, const Vector3d& mean) {
    return guess_log(file, table("time,x,y,z\n", [&](double t, const Vector3d& w, const Vector3d&) {
                       return fmt::format("{:.3f},{}\n", t, joined(mean + w));
                     }));
  };
  EXPECT_EQ(with("Gyroscope.csv", Vector3d::Zero()).part, LogGuess::Part::kGyro);
  const LogGuess magnetometer = with("Magnetometer.csv", {20, 5, -40});
  EXPECT_EQ(magnetometer.part, LogGuess::Part::kNone);
  EXPECT_TRUE(contains(magnetometer.aside, "of a magnetometer"));
  EXPECT_EQ(with("log.csv", {20, 5, -40}).part, LogGuess::Part::kNone);
  EXPECT_EQ(with("log.csv", {0, 0, 9.8}).part, LogGuess::Part::kAccel);
}

TEST(ColumnGuess, ImuAndReceiverInOneFile) {
  const LogGuess imu = guess_log(
      "all.csv",
      table("time,gx,gy,gz,ax,ay,az,latitude,longitude,altitude\n", [](double t, const Vector3d& w, const Vector3d& f) {
        return fmt::format("{:.3f},{},{},46.5,6.{},400\n", 1000 + t, joined(w), joined(f), 600 + static_cast<int>(t));
      }));
  EXPECT_EQ(imu.kind, LogKind::kImu);
  EXPECT_EQ(imu.columns->find("latitude"), nullptr);
  ASSERT_EQ(imu.beside.size(), 1U);
  EXPECT_EQ(imu.beside[0].kind, LogKind::kGnss);
  EXPECT_EQ(imu.beside[0].columns->find("gyro"), nullptr);
  EXPECT_EQ(columns_text(*imu.beside[0].columns, ""),
            "{time: {name: time, unit: s, of: boot},\nlatitude: {name: latitude, unit: deg},\n"
            "longitude: {name: longitude, unit: deg},\nheight: {name: altitude, unit: m},\nonly_new: true}");
}

// ---- Autopilots ----

TEST(ColumnGuess, Px4NumbersItsAxes) {
  const std::string text = table(
      "timestamp,gyro_rad[0],gyro_rad[1],gyro_rad[2],gyro_integral_dt,accelerometer_timestamp_relative,"
      "accelerometer_m_s2[0],accelerometer_m_s2[1],accelerometer_m_s2[2],accelerometer_clipping\n",
      [](double t, const Vector3d& w, const Vector3d& f) {
        return fmt::format("{:.0f},{},10000,0,{},0\n", 1e6 * (57 + t), joined(w), joined(f));
      });
  EXPECT_EQ(
      mapping("sensor_combined_0.csv", text),
      "{time: {name: timestamp, unit: us, of: boot},\n"
      "gyro: {names: ['gyro_rad[0]', 'gyro_rad[1]', 'gyro_rad[2]'], unit: 'rad/s'},\n"
      "accel: {names: ['accelerometer_m_s2[0]', 'accelerometer_m_s2[1]', 'accelerometer_m_s2[2]'], unit: 'm/s^2'}}");
}

TEST(ColumnGuess, ArduPilot) {
  const std::string found = mapping(
      "GPS.csv", receiver("timestamp,TimeUS,I,Status,GMS,GWk,NSats,HDop,Lat,Lng,Alt,Spd,GCrs,VZ,Yaw,U\n", [](int i) {
        return fmt::format("{}.25,{},0,6,{},2100,18,0.7,46.1{:03},7.2,2480.3,{},120.5,0.1,0,1\n", 1700000000 + i,
                           57000000 + 1000000 * i, 302400000 + 1000 * i, i, 4 + i % 3);
      }));
  EXPECT_EQ(found,
            "{time: {name: timestamp, unit: s, of: utc},\nlatitude: {name: Lat, unit: deg},\n"
            "longitude: {name: Lng, unit: deg},\nheight: {name: Alt, unit: m},\nspeed: {name: Spd, unit: 'm/s'},\n"
            "course: {name: GCrs, unit: deg}}");
}

// Its places are integers, its accuracies and velocities are not. What MAVLink calls eph is a dilution of precision.
TEST(ColumnGuess, Px4AndMavlinkMeanDifferentThingsByEph) {
  const auto with = [](const std::string& spread) {
    return mapping(
        "vehicle_gps_position_0.csv",
        receiver("timestamp,time_utc_usec,lat,lon,alt,alt_ellipsoid,s_variance_m_s,c_variance_rad,eph,epv,hdop,"
                 "vel_m_s,vel_n_m_s,vel_e_m_s,vel_d_m_s,cog_rad,fix_type\n",
                 [&](int i) {
                   return fmt::format("{},{},461234{:03},72345678,350000,400000,0.{},0.3,{},0.7,{},{},0,0,0,3\n",
                                      57000000 + 1000000 * i, 1700000000000000 + 1000000L * i, i, 1 + i % 3, spread,
                                      1 + i, 1 + i);
                 }));
  };
  const std::string px4 = with("0.45,0.9");
  EXPECT_TRUE(contains(px4, "horizontal_accuracy: {name: eph, unit: m}")) << px4;
  EXPECT_TRUE(contains(px4, "vertical_accuracy: {name: epv, unit: m}")) << px4;
  EXPECT_TRUE(contains(px4, "speed_accuracy: {name: s_variance_m_s, unit: 'm/s'}")) << px4;
  EXPECT_TRUE(contains(px4, "height: {name: alt_ellipsoid, unit: mm}")) << px4;
  EXPECT_TRUE(contains(px4, "velocity: {names: [vel_n_m_s, vel_e_m_s, vel_d_m_s], unit: 'm/s'}")) << px4;
  EXPECT_FALSE(contains(with("71,110"), "accuracy: {name: ep"));
}

// ---- Kinds of fixes ----

TEST(ColumnGuess, FixTypesOfUbloxAndOfMavlink) {
  const auto with = [](const std::string& types) {
    return guess_log("fixes.csv", receiver("gps_time_s,lat,lon,alt,fix_type\n", [&](int i) {
                       return fmt::format("{},46.5,6.{},400,{}\n", 400000 + i, 600 + i,
                                          types[static_cast<std::size_t>(i) % types.size()]);
                     }));
  };
  const auto said = [](const LogGuess& guess, const std::string& words) {
    return std::any_of(guess.doubts.begin(), guess.doubts.end(),
                       [&](const std::string& doubt) { return contains(doubt, words); });
  };
  const LogGuess rtk = with("1346");
  EXPECT_EQ(rtk.columns->find("fix")->valid, (std::vector<double>{3, 4, 5, 6, 7, 8}));
  EXPECT_TRUE(said(rtk, "as MAVLink and PX4 write it"));
  const LogGuess ublox = with("0335");
  EXPECT_EQ(ublox.columns->find("fix")->valid, (std::vector<double>{2, 3, 4}));
  EXPECT_TRUE(said(ublox, "as MAVLink writes it, 5 is RTK"));
  EXPECT_FALSE(said(with("3"), "RTK"));
}

// Of ArduPilot's RelAlt and Alt, and of DJI's heights above the take-off.
TEST(ColumnGuess, HeightsAboveTheStartAreNotThoseOfAReceiver) {
  const auto with = [](const std::string& names) {
    return mapping("gps.csv", receiver("time_s,lat,lon," + names + "\n", [](int i) {
                     return fmt::format("{},46.5,7.25{:04},{},{}\n", 0.2 * i, i, 0.1 * i, 612 + 0.1 * i);
                   }));
  };
  for (const char* relative : {"RelAlt", "height_above_takeoff(m)", "alt_agl_m"}) {
    EXPECT_TRUE(contains(with(std::string(relative) + ",Alt"), "height: {name: Alt")) << relative;
  }
  const std::string sea = with("altitudeAboveMeanSeaLevel,altitude");
  EXPECT_TRUE(contains(sea, "height: {name: altitude,")) << sea;
}

TEST(ColumnGuess, ATimeNamedDatenum) {
  const auto text = table("datenum,wx,wy,wz,ax,ay,az\n", [](double t, const Vector3d& w, const Vector3d& f) {
    return fmt::format("{:.10f},{},{}\n", 738100.25 + t / 86400, joined(w), joined(f));
  });
  EXPECT_TRUE(contains(mapping("imu.csv", text), "time: {name: datenum, unit: datenum, of: utc}"));
}

// Columns that say of every row that it has no fix are not what their names say.
TEST(ColumnGuess, WhatLeavesOutEveryRowIsNotUsed) {
  const auto with = [](const std::string& name, const std::string& value) {
    const auto text = receiver("time_s,lat,lon,alt," + name + "\n",
                               [&](int i) { return fmt::format("{},46.5,7.25{:04},612.5,{}\n", 0.2 * i, i, value); });
    return guess_log("gps.csv", text);
  };
  const LogGuess none = with("gps_quality", "0");
  EXPECT_EQ(none.columns->find("quality"), nullptr);
  ASSERT_FALSE(none.doubts.empty());
  EXPECT_TRUE(contains(none.doubts.back(), "gps_quality: says of every row that it has no fix"));
  EXPECT_NE(with("gps_quality", "4").columns->find("quality"), nullptr);
  EXPECT_EQ(with("Q", "0").columns->find("quality"), nullptr);
  EXPECT_EQ(with("hacc", "0.0").columns->find("horizontal_accuracy"), nullptr);
  EXPECT_NE(with("hacc", "2.5").columns->find("horizontal_accuracy"), nullptr);
}

TEST(ColumnGuess, PlacesThatAreNoDegreesAreRefusedByTheirCause) {
  const auto refused = [](const std::string& header, const std::string& place) {
    const auto text = receiver(header, [&](int i) { return fmt::format("{},{}\n", 100 + i, place); });
    return test::message_of<DataError>([&] { guess_log("sol.csv", text); });
  };
  const std::string earth = "4374851.1,614839.4,4582123.9";
  for (const char* header : {"time_s,ecef_x_m,ecef_y_m,ecef_z_m\n", "tow,pos_x,pos_y,pos_z\n"}) {
    EXPECT_TRUE(contains(refused(header, earth), "middle of the Earth (ECEF)")) << header;
  }
  EXPECT_FALSE(contains(refused("time_s,ecef_x_m,ecef_y_m,ecef_z_m\n", "4374851.1,1.4,2.9"), "ECEF"));
  const std::string text = refused("time_s,latitude,longitude,altitude\n", "46° 30.00' N,8° 0.1' E,612");
  EXPECT_TRUE(contains(text, "no number in its column `latitude`, but text such as `46° 30.00' N`")) << text;
}

// Accelerations of a car without gravity are often as large as 1: no forces in g, as they vanish at rest.
TEST(ColumnGuess, AccelerationsNearOneAreNotForcesInG) {
  const auto with = [](double at_rest) {
    test::Random random(3);
    return guess_log("Accelerometer.csv", table("time,z,y,x\n", [&](double t, const Vector3d&, const Vector3d&) {
                       const bool rests = t < 5;
                       const Vector3d f = rests ? Vector3d(0, 0, at_rest)
                                                : Vector3d(0.7 * std::sin(2 * t), 0.9 * std::cos(2 * t), 0.4);
                       return fmt::format("{:.3f},{}\n", t, joined(f + Vector3d::Constant(0.01 * random.uniform())));
                     }));
  };
  EXPECT_EQ(with(0).part, LogGuess::Part::kLinear);
  EXPECT_EQ(with(1).part, LogGuess::Part::kAccel);
}

// Rows of an IMU that repeat the last fix, and its own time beside the logger's.
TEST(ColumnGuess, AHeldFixHasItsOwnTime) {
  const auto with = [](double late) {
    int row = 0;
    return guess_log("log.csv", table("millis,gyro_x,gyro_y,gyro_z,acc_x,acc_y,acc_z,gnss_utc,lat,lon,alt\n",
                                      [&](double t, const Vector3d& w, const Vector3d& f) {
                                        const double fix = 0.25 * std::floor(t / 0.25),
                                                     stamp = fix - late * (row++ % 2);
                                        return fmt::format("{:.0f},{},{},{:.2f},46.5,{:.7f},612.5\n", 5000 + 1e3 * t,
                                                           joined(w), joined(f), 1.7e9 + stamp, 7.25 + 1e-5 * fix);
                                      }));
  };
  const LogGuess held = with(0);
  EXPECT_EQ(held.columns->time.name, "millis");
  ASSERT_EQ(held.beside.size(), 1U);
  EXPECT_EQ(held.beside[0].columns->time.name, "gnss_utc");
  EXPECT_EQ(held.beside[0].columns->time.of, TimeScale::kUtc);
  ASSERT_TRUE(held.beside[0].boot_time) << "the rows state both clocks";
  EXPECT_EQ(held.beside[0].boot_time->name, "millis");
  EXPECT_EQ(with(0.01).beside[0].columns->time.name, "millis") << "a time that changes in all rows is not the fix's";
}

// A magnetometer of unit length is steadier in motion than forces in g.
TEST(ColumnGuess, ForcesInGBesideAMagnetometerOfUnitLength) {
  for (const bool moves : {true, false}) {
    const auto text = table("", [moves](double t, const Vector3d& w, const Vector3d& f) {
      const double turn = moves ? 0.8 * (1 - std::cos(t)) : 0, push = moves && t > 6 ? 3 * std::sin(1.3 * t) : 0;
      const Vector3d field(0.45 * std::cos(turn), -0.45 * std::sin(turn), 0.893);
      return fmt::format("{:.3f} {} {} {}\n", t, joined(kDegreesPerRadian * w, ' '),
                         joined((f + Vector3d(push, 0.8 * push, 0)) / 9.80665, ' '), joined(field, ' '));
    });
    EXPECT_TRUE(contains(mapping("mt.txt", text), "accel: {names: [5, 6, 7], unit: g}")) << moves;
  }
}

TEST(ColumnGuess, RecordedLogs) {
  PISTE_REQUIRE_DATASETS();
  const std::string text = test::read_text(test::datasets() / "drive/imu_1934.csv");
  EXPECT_EQ(mapping("imu_1934.csv", text),
            "{time: {name: 7, unit: ms, of: boot},\ngyro: {names: [4, 5, 6], unit: 'deg/s'},\naccel: {names: [1, 2, "
            "3], unit: g}}");
}

// ---- The clock of a logger ----

TEST(ReceiverClock, ComesFromTheEarliestOfManyPairs) {
  std::vector<double> logger, gps;
  test::Random random(7);
  for (int i = 0; i < 1000; ++i) {
    const double late = 0.02 + 0.03 * random.uniform() + (i % 50 == 3 ? 2.0 : 0.0);
    gps.push_back(1000 + i);
    logger.push_back(5000 + i * (1 + 20e-6) + late);
  }
  const auto clock = fit_clock(logger, gps);
  ASSERT_TRUE(clock);
  EXPECT_NEAR(clock->drift, 20e-6, 4e-6);
  EXPECT_NEAR(clock->gps_time(5500.0), 1500 - 0.01 - 0.022, 0.005);
  EXPECT_LT(clock->scatter, 0.02);
  EXPECT_FALSE(fit_clock({1, 2}, {1, 2}));
}

}  // namespace
}  // namespace piste
