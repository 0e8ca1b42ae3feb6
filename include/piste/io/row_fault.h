#pragma once
/// Rows of a log that cannot be read. Normally the first one ends the reading with an error. `inspect` instead collects
/// them in a list.

#include <array>
#include <cstddef>
#include <string>
#include <utility>
#include <vector>

#include "piste/core/error.h"

namespace piste {

/// The order of the times of a file.
enum class TimeOrder {
  kIncreasing,
  kShared,  ///< some are equal
  kAny,     ///< rows are put in order once they are read
};

/// What is wrong with one row.
struct RowFault {
  enum class Kind {
    kText,          ///< text where a number is expected
    kNotFinite,     ///< NaN or infinite
    kFields,        ///< too few or too many fields, or an incomplete record
    kChecksum,      ///< the checksum is wrong
    kTimeRepeated,  ///< the same time as the row before
    kTimeBack,      ///< earlier than the row before
    kValue,         ///< an impossible number
  };
  static constexpr std::size_t kKinds = 7;
  Kind kind;
  std::size_t place;  ///< line, from 1; byte offset of a binary record, or row of a table, from 0
  std::string what;
};

/// The error of a row that cannot be read. `what()` reads `FILE:LINE: …`, or `FILE: byte OFFSET: …`.
class RowError : public DataError {
 public:
  RowError(const std::string& where, const RowFault& fault) : DataError(where, fault.what), fault_(fault) {}
  const RowFault& fault() const { return fault_; }

 private:
  RowFault fault_;
};

/// The place of a reader in its file, for errors.
class RowSource {
 public:
  enum class Counts { kLines, kBytes, kRows };
  RowSource(std::string file, Counts counts, std::size_t at = 0) : place(at), file_(std::move(file)), counts_(counts) {}

  const std::string& file() const { return file_; }
  /// `FILE:LINE`, `FILE: byte OFFSET`, or `NAME: row ROW`.
  std::string where() const;
  /// Throws a RowError with this place.
  [[noreturn]] void fail(const std::string& what, RowFault::Kind kind = RowFault::Kind::kValue) const;

 protected:
  std::size_t place;  ///< as RowFault::place

 private:
  std::string file_;
  Counts counts_;
};

/// The rows of one file that are left out, as they cannot be read: how many of each kind, and the first few of them.
struct RowFaults {
  static constexpr std::size_t kKept = 5;  ///< of each kind
  std::array<std::size_t, RowFault::kKinds> counts{};
  std::vector<RowFault> first;
  std::vector<std::string> unknown_columns;  ///< that were skipped
  std::string error_at;                      ///< where the first is, such as FILE:LINE
  bool for_use = false;                      ///< whether the other rows are used, and not only inspected

  void add(const RowFault& fault) {
    if (counts[static_cast<std::size_t>(fault.kind)]++ < kKept) first.push_back(fault);
  }
  std::size_t count(RowFault::Kind kind) const { return counts[static_cast<std::size_t>(kind)]; }
  std::size_t total() const {
    std::size_t sum = 0;
    for (const std::size_t n : counts) sum += n;
    return sum;
  }
};

/// Whether the log is read for use: then units are checked, and sigmas must be stated.
inline bool is_for_use(const RowFaults* faults) { return faults == nullptr || faults->for_use; }

/// Goes through the rows of a reader. `next()` goes to the next row and returns whether there is one; `row()` processes
/// it. If either throws a RowError, the reading ends; with `faults`, the error is listed there instead, and the row is
/// left out. If the other rows are for use, an impossible value still ends the reading.
template <class Next, class Row>
void for_each_row(RowFaults* faults, Next&& next, Row&& row) {
  for (;;) {
    try {
      if (!next()) return;
      row();
    } catch (const RowError& refused) {
      const bool judged = refused.fault().kind == RowFault::Kind::kValue;  // units, sigmas: of all rows, it may be
      if (faults == nullptr || (faults->for_use && judged)) throw;
      if (faults->error_at.empty()) faults->error_at = refused.where();
      faults->add(refused.fault());
    }
  }
}

}  // namespace piste
