#pragma once
/// GPS time of calendar dates, and of weeks.

#include <chrono>
#include <optional>
#include <string_view>

#include "io/text_reader.h"

namespace piste::log_formats {

/// A week counts from 1980-01-06, without roll-over.
struct GpsTime {
  int week = 0;
  double seconds = 0;  ///< of that week; may lie beyond it
};

enum class TimeSystem { kGps, kUtc, kJapan };  ///< Japan: UTC + 9 h

/// A day of the years 1980 (from 6 January) to 9999; none where there is no such day.
std::optional<std::chrono::sys_days> day_of(double year, double month, double day);

/// `second` of a day of the time system, as GPS time: of UTC with its leap seconds (IERS Bulletin C).
GpsTime gps_time(std::chrono::sys_days day, double second, TimeSystem system);
/// The same of a week and its seconds, counted in that time system.
GpsTime gps_time(const GpsTime& time, TimeSystem system);

/// Times that have their week, as seconds of the week that the first is in; refuses one that does not increase.
class WeekTime {
 public:
  /// Throws RowError of the row.
  double next(const GpsTime& time, const RowSource& row);

 private:
  IncreasingTime increasing_;
  std::optional<int> first_week_;
};

}  // namespace piste::log_formats
