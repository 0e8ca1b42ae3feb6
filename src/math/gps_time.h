#pragma once
/// GPS time from calendar dates, and from weeks and seconds.

#include <chrono>
#include <optional>

namespace piste {

/// A GPS week and the seconds in it. Weeks count from 1980-01-06, without rollover.
struct GpsTime {
  int week = 0;
  double seconds = 0;  ///< of that week; may lie beyond it
};

enum class TimeSystem { kGps, kUtc, kJapan };  ///< Japan: UTC + 9 h

/// A calendar day from 6 January 1980 to the end of 9999, or nothing if there is no such day.
std::optional<std::chrono::sys_days> day_of(double year, double month, double day);

/// GPS time of a second of a day in a time system. UTC is converted with its leap seconds (IERS Bulletin C).
GpsTime gps_time(std::chrono::sys_days day, double second, TimeSystem system);
/// GPS time of a week and its seconds that count in a time system.
GpsTime gps_time(const GpsTime& time, TimeSystem system);

}  // namespace piste
