#pragma once
/// A sample of the rows of a text log, by columns.

#include <functional>
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
  std::string along = {};          ///< direction of the column, if the log states it, such as `-y` or `west`
  std::vector<std::string_view> texts;  ///< of its fields, in the sampled text
  std::vector<double> values;           ///< the same as numbers, NaN where there is none
  std::string_view first() const;       ///< its first text that is not empty, or nothing
  std::string_view last() const;        ///< its last
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
  bool by_number = false;  ///< whether a mapping must number the columns, as only `inspect` knows their names

  /// The name of a column in a mapping: that of the header if it names no other column too, else the number.
  std::string name_of(std::size_t column) const;
  bool begins(std::size_t row) const;  ///< whether a stretch begins there

  /// The rows for which this holds, as a table of their own.
  ColumnTable rows_where(const std::function<bool(std::size_t)>& holds) const;
  /// The rows that have numbers in all of these columns.
  ColumnTable rows_with(std::span<const std::size_t> columns) const;
};

/// A table without rows, of columns with these cells.
ColumnTable table_with(std::vector<HeaderCell> cells, bool by_number);

/// Adds rows from several parts of a text, which must outlive the table: those lines for whose fields `is_row` holds.
void sample_rows(std::string_view text, TextReader::Separator separator, ColumnTable& table,
                 const std::function<bool(const std::vector<std::string_view>&)>& is_row);

/// Samples a text, which must outlive the table; nothing if it has no rows of numbers.
std::optional<ColumnTable> sample_columns(std::string_view text);

/// The words of a name, in lower case: parted where letters, digits and cases change, and at other signs.
std::vector<std::string> words_of(std::string_view name);

/// FIT's unit of angles, 180 deg / 2^31.
inline constexpr std::string_view kSemicircle = "8.3819031715393066e-8 deg";

/// The unit of times of day that are written as digits, such as 091731.4.
inline constexpr std::string_view kTimeOfDay = "hhmmss";

/// The unit that these words spell, such as `m/s` of `m s`; empty if it is none.
std::string unit_spelt(std::span<const std::string> words);

}  // namespace piste
