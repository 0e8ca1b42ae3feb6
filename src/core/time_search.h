#pragma once
/// Searches by time in sequences that are ordered by time (samples, fixes, rows: anything with a member `time`), and
/// the overlap of intervals.

#include <algorithm>
#include <cstddef>
#include <span>

#include "piste/core/log.h"

namespace piste {

inline constexpr double kSameInstant = 1e-6;  ///< s: times that differ by less are the same

/// Iterator to the first element at or after `time`, or to the end if all are before it.
template <class Samples>
auto first_at_or_after(const Samples& samples, double time) {
  return std::partition_point(samples.begin(), samples.end(), [time](const auto& s) { return s.time < time; });
}

/// The elements with begin ≤ time < end.
template <class Samples>
auto range(const Samples& samples, double begin, double end) {
  const auto first = first_at_or_after(samples, begin), last = first_at_or_after(samples, end);
  const auto count = last > first ? static_cast<std::size_t>(last - first) : 0;
  return std::span(samples.data() + (first - samples.begin()), count);
}

/// Length [s] of the time that two intervals have in common.
inline double overlap(const Interval& a, const Interval& b) {
  return std::max(0.0, std::min(a.end, b.end) - std::max(a.start, b.start));
}

}  // namespace piste
