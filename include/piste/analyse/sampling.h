#pragma once
/// When the rows of a log come: rate, jitter, gaps.

#include <cstddef>
#include <span>
#include <vector>

#include "piste/core/log.h"

namespace piste {

struct Sampling {
  std::size_t rows = 0;
  Interval span;
  double interval = 0;         ///< median [s]; 0 of fewer than two rows
  double jitter = 0;           ///< rms of the other intervals about it, gaps apart [s]
  double resolution = 0;       ///< of the time stamps [s]: what all of them are multiples of, to 1 µs; 0 where finer
  std::vector<Interval> gaps;  ///< from the row before to the row after
  std::size_t missing = 0;     ///< rows that the gaps would have held

  double rate() const { return interval > 0 ? 1 / interval : 0; }
};

/// A gap is an interval above 1.5 times the median that the intervals beside it do not make up for: a late time stamp
/// is none. @pre times increase
Sampling sampling(std::span<const double> time);

}  // namespace piste
