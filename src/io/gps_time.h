#pragma once
/// The times of a log that counts weeks.

#include <optional>

#include "io/text_reader.h"
#include "math/gps_time.h"

namespace piste::log_formats {

/// Converts times with a week into seconds of the week of the first time, and checks that they increase.
class WeekTime {
 public:
  /// `order`: as of IncreasingTime.
  explicit WeekTime(TimeOrder order = TimeOrder::kIncreasing) : increasing_(order) {}
  /// Throws RowError if the time does not increase.
  double next(const GpsTime& time, const RowSource& row);
  /// The week of the first time, once there was one.
  std::optional<int> first_week() const { return first_week_; }

 private:
  IncreasingTime increasing_;
  std::optional<int> first_week_;
};

}  // namespace piste::log_formats
