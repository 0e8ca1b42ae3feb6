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
  double interval = 0;    ///< mean interval, without those that miss a row [s]; 0 if there are fewer than two rows
  double jitter = 0;      ///< rms of the intervals about `interval`, without gaps [s]
  double resolution = 0;  ///< of the time stamps [s]: all are multiples of it to 1 µs; 0 if the resolution is finer
  std::vector<Interval> gaps;  ///< each from the row before the gap to the row after it
  std::size_t missing = 0;     ///< number of rows that are missing in the gaps

  double rate() const { return interval > 0 ? 1 / interval : 0; }
};

/// Examines times. Gaps are found as condition() finds them: by the clock that the rows as a whole keep.
/// @pre times increase
Sampling sampling(std::span<const double> time);

/// Lists the faults of the rows of any log: rows that could not be read, time stamps in another unit than seconds or of
/// another clock than GPS seconds of week, gaps, jitter. `fastest` and `slowest` are the limits of the row rates of
/// such logs [Hz].
std::vector<Suspicion> suspicions(const Sampling& sampling, const RowFaults& faults, const std::string& file,
                                  double fastest, double slowest);

}  // namespace piste
