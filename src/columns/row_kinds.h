#pragma once
/// Finds the column that names the sensor of each row in a log of several sensors.

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

/// Nothing if there is no such column.
std::optional<RowKinds> row_kinds(const ColumnTable& table);

}  // namespace piste
