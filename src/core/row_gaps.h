#pragma once
/// Finds where rows of a log are missing, by the clock that rows keep as a whole.

#include <cstddef>
#include <span>
#include <vector>

#include "piste/core/behaviour.h"

namespace piste {

/// The clock of the rows, and where it says that some are missing.
struct RowGaps {
  double period = 0;               ///< mean interval where no row is missing [s]; 0 if there are fewer than two rows
  std::vector<std::size_t> after;  ///< ascending: rows are missing before each of these

  /// Whether rows are missing before row i.
  bool before(std::size_t i) const;
};

/// Rows are missing in an interval if it is longer than 1.5 periods, and if the clock is still behind by half a period
/// however many of the eight intervals on either side are added to it. So stamps that are late, rounded (6, 7, 8 and
/// 9 ms of a clock that counts milliseconds) or given to a whole packet of rows at its arrival are no gaps. These
/// numbers are the defaults of the options.
///
/// The period is first a low quantile of the means over sixteen intervals, which neither rounding nor gaps disturb, and
/// then the mean of all intervals in which nothing is missing by it.
/// @pre times increase
RowGaps find_gaps(std::span<const double> time, const GapOptions& options = {});

}  // namespace piste
