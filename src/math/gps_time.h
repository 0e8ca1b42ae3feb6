#pragma once
/// GPS time from calendar dates, and from weeks and seconds.

#include <chrono>
#include <optional>
#include <string>

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

/// A calendar time to the microsecond; `second` is 60 in a leap second.
struct CalendarTime {
  int year = 0, month = 0, day = 0, hour = 0, minute = 0, second = 0, microsecond = 0;
};
/// The calendar time of a GPS time, rounded to the microsecond, in GPS time or UTC.
CalendarTime calendar_time(const GpsTime& time, TimeSystem system);

/// Its text in UTC, such as 2022-03-09T11:59:42.500000Z.
std::string utc_text(const GpsTime& time);

/// Seconds since 1970-01-01 in UTC, which does not count leap seconds.
double unix_time(const GpsTime& time);

}  // namespace piste
