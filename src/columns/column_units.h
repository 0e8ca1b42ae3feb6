#pragma once
/// The units that the header of a text log gives its columns.

#include <cstddef>
#include <string>

#include "column_table.h"
#include "piste/math/units.h"

namespace piste {

/// Whether the unit in the header's brackets, or in a line of units, is known as it stands.
bool has_known_brackets(const ColumnTable& table, std::size_t column, const Dimension& dimension);

/// Whether the header gives the unit, so or by the name.
bool has_unit(const ColumnTable& table, std::size_t column, const Dimension& dimension);

/// The unit to be written. It is none if the unit in the header's brackets is known unchanged. Else it is the unit in
/// the header's words, such as `ft` at the end of a name, or else `else_unit`.
std::string unit_of(const ColumnTable& table, std::size_t column, const Dimension& dimension,
                    const std::string& else_unit);

}  // namespace piste
