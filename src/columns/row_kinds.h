#pragma once
/// Finds which column of a log of several sensors says of which sensor each row is.

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "column_table.h"

namespace piste {

/// The column, and its texts: a kind of message, such as `UncalGyro`, or the number of an IMU.
struct RowKinds {
  std::size_t column = 0;
  std::vector<std::string> kinds;
  bool numbered = false;  ///< whether they are numbers of IMUs
};

/// Nothing if no column says so.
std::optional<RowKinds> row_kinds(const ColumnTable& table);

}  // namespace piste
