#pragma once
/// The rows that the key `repair` leaves out of a log.

#include "piste/core/log.h"
#include "piste/io/log_io.h"

namespace piste {

/// Lists the rows that a reader cannot read, and counts them. If they are many, the fault is not in the rows.
class LeftOutRows {
 public:
  /// `faults`: the list of an inspection, or nullptr.
  LeftOutRows(const LogFile& log, RowFaults* faults) : asked_(faults == nullptr && log.repair), listed_(faults) {
    left_out_.for_use = true;
  }
  /// Where they are to be listed; nullptr: such a row ends the reading.
  RowFaults* list() { return asked_ ? &left_out_ : listed_; }
  /// Whether they are at most one row in ten. `rows`: how many could be read.
  static bool are_few(std::size_t left_out, std::size_t rows) {
    constexpr std::size_t kFewest = 10;
    return kFewest * left_out <= rows + left_out;
  }
  /// Counts them. Throws the error of the first if they are more than a few.
  void count_in(RepairedRows& repaired, std::size_t rows) const {
    const std::size_t count = left_out_.total();
    if (!are_few(count, rows)) throw DataError(left_out_.error_at, left_out_.first.front().what);
    repaired.unreadable += count;
  }

 private:
  bool asked_;
  RowFaults left_out_;
  RowFaults* listed_;
};

}  // namespace piste
