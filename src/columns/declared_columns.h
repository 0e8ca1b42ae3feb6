#pragma once
/// What the head of a log says of its columns in a way of its own.

#include <string_view>

#include "column_table.h"

namespace piste {

/// Gives columns the units and directions that a head states: Gyroflow by `tscale`, `gscale`, `ascale` and
/// `orientation`; VBOX by being one, as its places are in minutes of arc, to the west, and its times in digits.
void declare_columns(std::string_view text, ColumnTable& table);

}  // namespace piste
