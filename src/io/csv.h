#pragma once
/// Reads and writes CSV files whose header names the columns with their units.

#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "io/text_reader.h"
#include "piste/io/log_io.h"
#include "piste/io/text_sink.h"

namespace piste {

/// The rows of a table in memory, one after the other.
class TableRows : public RowSource {
 public:
  TableRows(const std::string& name, NumberColumns table) : RowSource(name, Counts::kRows), table_(std::move(table)) {}
  const std::vector<NumberColumn>& columns() const { return table_.columns; }
  /// Goes to the next row; false behind the last.
  bool next();
  /// The number in a column. Throws if it is not finite.
  double number(std::size_t column) const;

 private:
  NumberColumns table_;
  std::size_t following_ = 0;
};

/// A text as a cell: in quotes where it has a comma, a quote or a line's end.
std::string csv_cell(const std::string& text);

/// Reads rows of finite numbers, of a file or of a table in memory. First ask for each column by `column()` or
/// `find()`, then call `finish_header()`, then `next()` row by row. Every error is a DataError `FILE:LINE: …`.
class CsvReader {
 public:
  /// Reads the header of the log: of its table, its bytes or its file, whichever it has. Columns in `ignore_columns`
  /// are not parsed; to name one that is not there is an error.
  explicit CsvReader(const LogFile& log);
  explicit CsvReader(const std::string& file, std::span<const std::string> ignore_columns = {});

  /// Asks for a column, and returns its index for `value()`. `column` throws if there is no such column; `find` returns
  /// nothing.
  std::size_t column(std::string_view name);
  std::optional<std::size_t> find(std::string_view name);
  /// Throws if there is a column that was not asked for. With `faults`, such columns are listed there and skipped.
  void finish_header(RowFaults* faults = nullptr);

  /// Goes to the next row; false at the end of the file.
  bool next();
  double value(std::size_t column) const { return values_[column]; }
  double operator[](std::size_t column) const { return values_[column]; }

  /// The names of all columns.
  const std::vector<std::string>& names() const { return names_; }
  /// The place of the row.
  const RowSource& text() const { return table_ ? static_cast<const RowSource&>(*table_) : *text_; }
  /// Throws an error of this row, or of the header before the first row. A header that cannot be read always ends the
  /// reading.
  [[noreturn]] void fail(const std::string& what) const;

 private:
  enum class Use : char { kNone, kIgnored, kClaimed };
  void take_header(std::span<const std::string> ignore_columns);
  std::optional<TextReader> text_;
  std::optional<TableRows> table_;
  std::vector<std::string> names_, asked_;
  std::vector<Use> use_;
  std::vector<double> values_;
  bool in_rows_ = false;
};

/// A column of a CsvWriter: its header, and the number of digits after the decimal point.
struct CsvColumn {
  std::string name;
  int decimals;
};

/// Writes a CSV file to a sink, or keeps its text where there is none. Equal numbers give equal bytes.
class CsvWriter {
 public:
  /// `text_column`: name of a last column of text, or empty.
  explicit CsvWriter(std::vector<CsvColumn> columns, TextSink sink = {}, std::string_view text_column = {});
  /// Adds a row. @pre as many values as columns
  void row(std::span<const double> values, std::string_view text = {});
  /// Gives the remaining text to the sink.
  void finish();
  /// The whole text. Only without a sink.
  const std::string& text() const& { return text_; }
  std::string text() && { return std::move(text_); }

 private:
  std::vector<CsvColumn> columns_;
  TextSink sink_;
  std::string text_, row_;
};

/// Appends `value` with `decimals` digits (0 to 12) after the decimal point, rounded to nearest.
void append_fixed(std::string& text, double value, int decimals);

}  // namespace piste
