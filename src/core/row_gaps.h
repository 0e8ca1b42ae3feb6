#pragma once
/// Detects missing rows of a log by the clock of all its rows.

#include <cstddef>
#include <span>
#include <vector>

#include "piste/core/behaviour.h"

namespace piste {

/// The clock of the rows, and the places where rows are missing by it.
struct RowGaps {
  double period = 0;               ///< mean interval where no row is missing [s]; 0 if there are fewer than two rows
  std::vector<std::size_t> after;  ///< ascending: rows are missing before each of these

  /// Whether rows are missing before row i.
  bool before(std::size_t i) const;
};

/// Rows are missing in an interval if it is longer than 1.5 periods and the clock stays behind by half a period. The
/// latter must hold however many of the eight intervals on either side are added. So late or rounded stamps are no gaps
/// (6, 7, 8 and 9 ms of a clock that counts milliseconds). Nor is one stamp for a whole packet of rows at its arrival.
/// These numbers are the defaults of the options.
///
/// The period is first a low quantile of the means over sixteen intervals, which neither rounding nor gaps disturb.
/// Then it is the mean of all intervals without a missing row by that estimate.
/// @pre times increase
RowGaps find_gaps(std::span<const double> time, const GapOptions& options = {});

}  // namespace piste
