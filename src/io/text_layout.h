#pragma once
/// Determines the layout of a text log: its delimiter, and the lines of its header and its rows.

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "io/text_reader.h"
#include "piste/io/columns.h"

namespace piste {

/// Lines count from 1.
struct TextLayout {
  Delimiter delimiter = Delimiter::kComma;
  std::size_t header = 0;   ///< line of the header, or 0
  std::size_t units = 0;    ///< line of the units below it, or 0
  std::size_t rows = 0;     ///< line of the first row
  std::size_t columns = 0;  ///< in the first row, without an empty field at its end
};

/// A header's cell, such as `GyroX [rad/s]`: whole, and split into name and unit.
struct HeaderCell {
  std::string whole, name, unit;
};

/// The number from 1 by which a column is named; nothing if the name is none.
std::optional<std::size_t> column_number(std::string_view name);

TextReader::Separator separator_of(Delimiter delimiter);

/// Determines the layout from the first lines. Rows are the lines of numbers with as many fields as most lines. The
/// header is the line above the first row if it has as many fields. What `given` states is taken as it is. Nothing if
/// there are no rows. Where `given.rows` numbers its column, only these rows are looked at.
std::optional<TextLayout> find_layout(std::string_view text, const ColumnMap& given);

/// Splits a header's fields. A mark of a comment before the first, and quotes, are left out; a mark that is a field of
/// its own, too, if there are more fields than `columns`.
std::vector<HeaderCell> header_cells(const std::vector<std::string_view>& fields, std::size_t columns);

/// Gives the cells that have no unit that of the line of units.
void add_units(std::vector<HeaderCell>& cells, const std::vector<std::string_view>& fields);

}  // namespace piste
