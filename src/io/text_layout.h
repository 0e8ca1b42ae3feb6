#pragma once
/// Finds how a text log is laid out: what separates its fields, and where its header and its rows stand.

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
  std::size_t header = 0;  ///< line of the header, or 0
  std::size_t rows = 0;    ///< line of the first row
};

/// A header's cell, such as `GyroX [rad/s]`: whole, and split into name and unit.
struct HeaderCell {
  std::string whole, name, unit;
};

TextReader::Separator separator_of(Delimiter delimiter);

/// Finds the layout from the first lines: rows are those that hold numbers and have as many fields as most, and
/// the header is the line above the first if it has as many. What `given` states is taken as it is. Nothing if there
/// are no rows.
std::optional<TextLayout> find_layout(std::string_view text, const ColumnMap& given);

/// Splits a header's fields. A mark of a comment before the first, and quotes, are left out.
std::vector<HeaderCell> header_cells(const std::vector<std::string_view>& fields);

}  // namespace piste
