#pragma once
/// Reads the rows of a text log by a mapping of its columns.

#include <limits>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "io/counter_rollover.h"
#include "io/gps_time.h"
#include "io/text_layout.h"
#include "io/text_reader.h"
#include "piste/io/columns.h"

namespace piste::log_formats {

/// A column, and the factor from its unit to SI and radians.
struct Column {
  std::size_t index = 0;
  double factor = 1;
};

/// Goes through the rows. Errors are DataErrors `FILE:LINE: …`; those of the header end the reading in any case.
class ColumnReader {
 public:
  /// Throws if the file has no rows of numbers. With `map.rows` only these are rows.
  ColumnReader(const std::string& file, const ColumnMap& map, std::optional<std::string_view> content);

  /// The column `name` of the quantity `key`. `unit`: of the configuration; empty: that of the header. Throws if there
  /// is no such column, or none or a wrong unit.
  Column column(const std::string& name, std::string_view key, const std::string& unit, const Dimension&) const;
  /// The same without a unit.
  std::size_t place_of(const std::string& name, std::string_view key) const;
  /// All columns of a quantity; empty if the mapping has none.
  std::vector<Column> columns(const ColumnMap& map, const ColumnQuantity& quantity) const;

  /// Goes to the next row. Throws if it has too few or too many fields, and at the end if no row was of this sensor.
  bool next();
  const TextReader& text() const { return text_; }
  /// Throws RowError if the field is no number, or not finite in SI units.
  double value(const Column& column) const;
  /// Whether the field is neither empty nor says that there is no value, such as `nan`.
  bool has_value(const Column& column) const;
  /// The value, or nothing if there is none.
  std::optional<double> find_value(const Column& column) const;

 private:
  struct Chosen {
    std::size_t place = 0;
    ColumnRows rows;
  };
  bool is_chosen() const;
  [[noreturn]] void fail_without_rows() const;

  TextReader text_;
  std::size_t header_ = 0, fields_ = 0;
  std::vector<HeaderCell> cells_;
  std::vector<Chosen> chosen_;
  bool at_row_ = false, any_ = false;
};

/// Reads the time of the rows of a reader.
class ColumnClock {
 public:
  /// Throws as ColumnReader::column.
  ColumnClock(const ColumnReader& reader, const ColumnTime& time, TimeOrder order);
  /// The time of the present row. Throws RowError if it is none, or does not increase.
  double next();
  /// The GPS week of the first row, if the times of the log have one.
  std::optional<int> first_week() const { return weeks_.first_week(); }

 private:
  double since_power_up();
  double since_midnight() const;
  GpsTime since_epoch() const;
  GpsTime of_days() const;
  GpsTime calendar();
  double rest() const { return rest_ ? reader_.value(*rest_) : 0; }

  const ColumnReader& reader_;
  TimeScale of_;
  bool calendar_, digits_;
  std::optional<int> day_zero_;  // of times in days: 1 January 1970 as they count
  Column time_;
  std::optional<Column> rest_;
  std::optional<std::size_t> week_, date_;
  std::optional<bool> month_first_;  // of dates such as 08/04/2020
  CounterRollover rollover_;
  IncreasingTime increasing_;
  WeekTime weeks_;
};

}  // namespace piste::log_formats
