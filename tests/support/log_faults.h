#pragma once
/// Faults of real logs, seeded into good ones.

#include <functional>
#include <numbers>
#include <string>
#include <vector>

#include "piste/core/log.h"
#include "piste/inspect/suspicion.h"

namespace piste::test {

/// Logs of an IMU and a receiver on one body.
struct Logs {
  std::string name;
  ImuRecording imu;
  GnssRecording gnss;
};

struct SeededFault {
  std::string name;
  LogFault fault;  ///< that must be reported first
  std::function<void(Logs&)> spoil;
};

inline void multiply(std::vector<Vector3d>& values, double factor) {
  for (Vector3d& v : values) v *= factor;
}
inline void turn(std::vector<Vector3d>& values, const Matrix3d& by) {
  for (Vector3d& v : values) v = by * v;
}
inline void by_interval(ImuRecording& imu, bool times) {
  for (std::size_t i = 0; i < imu.time.size(); ++i) {
    const std::size_t later = std::max<std::size_t>(i, 1);
    const double dt = imu.time[later] - imu.time[later - 1], factor = times ? dt : 1 / dt;
    imu.gyro[i] *= factor;
    imu.accel[i] *= factor;
  }
}
/// Converts to rates, if the log holds increments.
inline void as_rates(ImuRecording& imu) {
  if (!imu.increments) return;
  by_interval(imu, false);
  imu.increments = false;
}
inline void shift(std::vector<double>& time, double by) {
  for (double& t : time) t += by;
}
inline Matrix3d rows(const Vector3d& a, const Vector3d& b, const Vector3d& c) {
  Matrix3d m;
  m << a.transpose(), b.transpose(), c.transpose();
  return m;
}
inline const Vector3d kX = Vector3d::UnitX(), kY = Vector3d::UnitY(), kZ = Vector3d::UnitZ();

template <class Change>
void each_velocity(Logs& logs, Change&& change) {
  for (GeodeticFix& f : logs.gnss.fixes) {
    if (f.velocity) change(f.velocity->value);
  }
}

/// Faults of an IMU that show against a receiver. The log may hold rates or increments.
inline std::vector<SeededFault> imu_faults() {
  using std::numbers::pi;
  const Matrix3d swap_xy = rows(kY, kX, kZ), swap_yz = rows(kX, kZ, kY);
  return {
      {"degrees as radians", LogFault::kGyroDegrees, [](Logs& l) { multiply(l.imu.gyro, 180 / pi); }},
      {"radians as degrees", LogFault::kGyroRadians, [](Logs& l) { multiply(l.imu.gyro, pi / 180); }},
      {"g as m/s^2", LogFault::kAccelG, [](Logs& l) { multiply(l.imu.accel, 1 / 9.80665); }},
      {"m/s^2 as g", LogFault::kAccelMetres, [](Logs& l) { multiply(l.imu.accel, 9.80665); }},
      {"increments as rates", LogFault::kIncrementsForRates,
       [](Logs& l) {
         as_rates(l.imu);
         by_interval(l.imu, true);
       }},
      {"rates as increments", LogFault::kRatesForIncrements,
       [](Logs& l) {
         as_rates(l.imu);
         l.imu.increments = true;
       }},
      {"x and y interchanged", LogFault::kAxesMirrored,
       [swap_xy](Logs& l) {
         turn(l.imu.gyro, swap_xy);
         turn(l.imu.accel, swap_xy);
       }},
      {"z reversed", LogFault::kAxesMirrored,
       [](Logs& l) {
         turn(l.imu.gyro, rows(kX, kY, -kZ));
         turn(l.imu.accel, rows(kX, kY, -kZ));
       }},
      {"gyro y and z interchanged", LogFault::kGyroAxes, [swap_yz](Logs& l) { turn(l.imu.gyro, swap_yz); }},
      {"gyro z reversed", LogFault::kGyroAxes, [](Logs& l) { turn(l.imu.gyro, rows(kX, kY, -kZ)); }},
      {"forces reversed", LogFault::kAccelSign, [](Logs& l) { multiply(l.imu.accel, -1); }},
      {"leap seconds", LogFault::kLeapSeconds, [](Logs& l) { shift(l.imu.time, -18); }},
      {"receiver in UTC", LogFault::kLeapSeconds,
       [](Logs& l) {
         for (GeodeticFix& f : l.gnss.fixes) f.time -= 18;
       }},
      {"an hour", LogFault::kClockOffset, [](Logs& l) { shift(l.imu.time, 3600); }},
      {"local time", LogFault::kClockOffset, [](Logs& l) { shift(l.imu.time, -7 * 3600 - 18); }},
      {"seconds of the day", LogFault::kNotSecondsOfWeek, [](Logs& l) { shift(l.imu.time, -86400); }},
      {"3.7 s", LogFault::kClockOffset, [](Logs& l) { shift(l.imu.time, 3.7); }},
      {"seconds since switched on", LogFault::kNoOverlap,
       [](Logs& l) { shift(l.imu.time, 12.5 - l.imu.time.front()); }},
  };
}

/// Faults of a receiver.
inline std::vector<SeededFault> gnss_faults() {
  const auto rounded = [](double angle, double step) {
    const double degrees = angle * 180 / std::numbers::pi;
    return std::round(degrees / step) * step * std::numbers::pi / 180;
  };
  return {
      {"east-north-up", LogFault::kVelocityEastNorth,
       [](Logs& l) { each_velocity(l, [](Vector3d& v) { v = Vector3d(v.y(), v.x(), -v.z()); }); }},
      {"km/h", LogFault::kVelocityUnit, [](Logs& l) { each_velocity(l, [](Vector3d& v) { v *= 3.6; }); }},
      {"knots", LogFault::kVelocityUnit, [](Logs& l) { each_velocity(l, [](Vector3d& v) { v *= 3600 / 1852.0; }); }},
      {"latitude and longitude interchanged", LogFault::kLatitudeLongitude,
       [](Logs& l) {
         for (GeodeticFix& f : l.gnss.fixes) std::swap(f.position.latitude, f.position.longitude);
       }},
      {"milliseconds", LogFault::kTimeUnit,
       [](Logs& l) {
         for (GeodeticFix& f : l.gnss.fixes) f.time *= 1e3;
       }},
      {"the same fix for 10 s", LogFault::kRepeatedFix,
       [](Logs& l) {
         auto& fixes = l.gnss.fixes;
         std::size_t i = fixes.size() / 2;
         for (std::size_t k = i + 1; k < fixes.size() && fixes[k].time < fixes[i].time + 10; ++k) {
           const double time = fixes[k].time;
           fixes[k] = fixes[i];
           fixes[k].time = time;
         }
       }},
      {"jumps of 30 m", LogFault::kPositionJumps,
       [](Logs& l) {
         auto& fixes = l.gnss.fixes;
         for (const std::size_t part : {3, 5, 6}) fixes[part * fixes.size() / 9].position.latitude += 30 / 6371e3;
       }},
      {"sigmas ten times too small", LogFault::kSigmaTooSmall,
       [](Logs& l) {
         for (GeodeticFix& f : l.gnss.fixes) f.sigma_position /= 10;
       }},
      {"sigmas of zero", LogFault::kSigmaTooSmall,
       [](Logs& l) {
         for (std::size_t i = 0; i < l.gnss.fixes.size(); i += 7) l.gnss.fixes[i].sigma_position.setZero();
       }},
      {"coordinates rounded to 1e-4 deg", LogFault::kCoordinatesRounded,
       [rounded](Logs& l) {
         for (GeodeticFix& f : l.gnss.fixes) {
           f.position.latitude = rounded(f.position.latitude, 1e-4);
           f.position.longitude = rounded(f.position.longitude, 1e-4);
         }
       }},
  };
}

}  // namespace piste::test
