#pragma once
/// Finds which column of a text log is the time of its rows.

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "column_names.h"
#include "column_table.h"
#include "column_values.h"
#include "piste/io/columns.h"

namespace piste {

struct FoundTime {
  ColumnTime time;  ///< of GPS or UTC if there is one
  std::size_t column = 0;
  std::optional<ColumnTime> boot = {};  ///< beside such a one: a time since power-up
};

/// The time by its name, else, without a header, by its steps; of a clock that tells the rows apart, if there is one.
/// Throws DataError where a named time keeps falling back.
std::optional<FoundTime> find_time(const std::string& file, const ColumnTable& table,
                                   const std::vector<ColumnMeaning>& meanings, const Pace& pace);

}  // namespace piste
