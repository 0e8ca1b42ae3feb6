#pragma once
/// When the rows of a log come, and what is wrong with that: rate, jitter, gaps, refused rows.

#include <cstddef>
#include <span>
#include <string>
#include <vector>

#include "piste/core/log.h"
#include "piste/inspect/suspicion.h"
#include "piste/io/row_fault.h"

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

/// What looks wrong with the rows of any log: those refused, time stamps in another unit or of another clock than GPS
/// seconds of week, gaps, jitter. `fastest` and `slowest` bound the rates that such a log has [Hz].
std::vector<Suspicion> suspicions(const Sampling& sampling, const RowFaults& faults, const std::string& file,
                                  double fastest, double slowest);

}  // namespace piste
