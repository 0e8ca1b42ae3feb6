#pragma once
/// Determines the column of a text log that is the time of its rows.

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
  std::optional<ColumnTime> boot = {};  ///< in addition to such a one: a time since power-up
};

/// The time by its name, else, without a header, by its steps. A clock that differs from row to row is preferred.
/// Throws DataError if a named time keeps falling back.
std::optional<FoundTime> find_time(const std::string& file, const ColumnTable& table,
                                   const std::vector<ColumnMeaning>& meanings, const Pace& pace,
                                   const std::string& owner = {});

}  // namespace piste
