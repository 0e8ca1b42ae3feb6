#pragma once
/// Lengths of time [s].

#include <cmath>

namespace piste {

inline constexpr double kHour = 3600, kDay = 24 * kHour, kWeek = 7 * kDay;

/// Whole weeks [s] that bring the seconds of week `time` to the week of `other`: one log may begin before a week's end
/// and the other after it. Zero if the two then still differ by more than a day: then something else is wrong.
inline double week_shift(double time, double other) {
  const double apart = other - time, shift = kWeek * std::round(apart / kWeek);
  return std::abs(apart - shift) < kDay ? shift : 0;
}

}  // namespace piste
