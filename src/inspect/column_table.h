#pragma once
/// A sample of the rows of a text log, by columns.

#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "io/text_layout.h"

namespace piste {

/// One column.
struct SampledColumn {
  HeaderCell cell;                 ///< empty if there is no header
  std::vector<std::string> words;  ///< of its name, in lower case: `accelerometerTimestamp_sinceReboot` has four
  std::string unit;                ///< that the name ends with, such as `rad` of `lat_rad`, whose words are without it
  std::vector<double> values;      ///< NaN where there is no number
  std::string first, last;         ///< the texts of its first and last field in the first stretch
  bool has(std::string_view word) const;
  bool has_any(std::initializer_list<std::string_view> any) const;
  bool is_whole() const;  ///< whether all its numbers are whole
};

/// The table. Rows are taken in stretches from several parts of the file.
struct ColumnTable {
  std::vector<SampledColumn> columns;
  std::vector<std::size_t> stretches;  ///< the first row of each
  std::size_t rows = 0;
  bool header = false;

  /// The name of a column in a mapping: that of the header if it names no other column too, else the number.
  std::string name_of(std::size_t column) const;
  bool begins(std::size_t row) const;  ///< whether a stretch begins there
};

/// Samples a text; nothing if it has no rows of numbers.
std::optional<ColumnTable> sample_columns(std::string_view text);

/// The words of a name, in lower case: parted where letters, digits and cases change, and at other signs.
std::vector<std::string> words_of(std::string_view name);

/// The unit that these words spell, such as `m/s` of `m s`; empty if it is none.
std::string unit_spelt(std::span<const std::string> words);

}  // namespace piste
