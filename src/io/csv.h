#pragma once
/// CSV with a header that names columns and units, in and out.

#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "io/text_reader.h"

namespace piste {

/// Reads rows of finite numbers. First claim the columns, then `finish_header()`, then `next()` row by row.
/// Every error is a DataError `FILE:LINE: …`.
class CsvReader {
 public:
  /// Reads the header. Columns in `ignore_columns` are not parsed; naming one that is not there is an error.
  /// With `content`, that is read and `file` only names it.
  CsvReader(const std::string& file, std::span<const std::string> ignore_columns = {},
            std::optional<std::string_view> content = {});

  /// Index of a column for `value()`, which becomes a claimed one; refused where it is missing.
  std::size_t column(std::string_view name);
  std::optional<std::size_t> find(std::string_view name);
  /// Refuses columns that nobody claimed; with `faults` they are listed there and passed over.
  void finish_header(RowFaults* faults = nullptr);

  /// Goes to the next row; false at the end of the file.
  bool next();
  double value(std::size_t column) const { return values_[column]; }
  double operator[](std::size_t column) const { return values_[column]; }

  const TextReader& text() const { return text_; }
  /// Throws of this row, or of the header: a header that cannot be read ends every reading.
  [[noreturn]] void fail(const std::string& what) const;

 private:
  enum class Use : char { kNone, kIgnored, kClaimed };
  TextReader text_;
  std::vector<std::string> names_, asked_;
  std::vector<Use> use_;
  std::vector<double> values_;
  bool in_rows_ = false;
};

/// One column that a CsvWriter writes: its header, and digits after the point.
struct CsvColumn {
  std::string name;
  int decimals;
};

/// Builds the text of a CSV file. The same numbers give the same bytes.
class CsvWriter {
 public:
  explicit CsvWriter(std::vector<CsvColumn> columns);
  void reserve(std::size_t rows) { text_.reserve(text_.size() + rows * columns_.size() * 12); }
  /// One row; as many values as columns.
  void row(std::span<const double> values);
  const std::string& text() const& { return text_; }
  std::string text() && { return std::move(text_); }

 private:
  std::vector<CsvColumn> columns_;
  std::string text_;
};

/// Appends `value` with that many digits after the point (0 to 12), rounded to nearest.
void append_fixed(std::string& text, double value, int decimals);

}  // namespace piste
