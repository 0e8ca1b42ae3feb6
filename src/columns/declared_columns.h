#pragma once
/// Statements about columns in the head of a log, in the log's own format.

#include <string_view>

#include "column_table.h"

namespace piste {

/// Gives columns the units and directions that a head states. Gyroflow states them by `tscale`, `gscale`, `ascale` and
/// `orientation`. VBOX always has positions in minutes of arc, to the west, and times in digits.
void declare_columns(std::string_view text, ColumnTable& table);

}  // namespace piste
