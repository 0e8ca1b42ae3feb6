#pragma once
/// Examines the times of a log's rows: rate, jitter, gaps.

#include <cstddef>
#include <span>
#include <string>
#include <vector>

#include "piste/core/log.h"
#include "piste/inspect/suspicion.h"
#include "piste/io/row_fault.h"

namespace piste {

/// The result.
struct Sampling {
  std::size_t rows = 0;
  Interval span;
  double interval = 0;         ///< mean where no row is missing [s]; 0 if there are fewer than two rows
  double jitter = 0;           ///< rms of the intervals about it, without gaps [s]
  double resolution = 0;       ///< of the time stamps [s]: all are multiples of it to 1 µs; 0 if it is smaller
  std::vector<Interval> gaps;  ///< from the row before to the row after
  std::size_t missing = 0;     ///< rows that are missing in the gaps

  double rate() const { return interval > 0 ? 1 / interval : 0; }
};

/// Examines times. Gaps are those of condition(), which judges intervals by the clock that the rows keep as a whole.
/// @pre times increase
Sampling sampling(std::span<const double> time);

/// What looks wrong with the rows of any log: rows that could not be read, time stamps in another unit or of another
/// clock than GPS seconds of week, gaps, jitter. `fastest` and `slowest` are the limits of the rates of such logs [Hz].
std::vector<Suspicion> suspicions(const Sampling& sampling, const RowFaults& faults, const std::string& file,
                                  double fastest, double slowest);

}  // namespace piste
