#pragma once
/// The mapping of the columns of a text log whose names are its own (`format: columns`).

#include <cstddef>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "piste/math/units.h"

namespace piste {

/// What separates the fields of a row.
enum class Delimiter { kComma, kSemicolon, kTab, kBlanks };

/// Units of times in days: since the year 0 as MATLAB counts them (datenum), and since 30 December 1899 as spreadsheets
/// do.
inline constexpr std::string_view kDatenum = "datenum", kSheetDays = "sheet_days";

/// The unit of latitudes and longitudes as NMEA writes them: degrees and minutes, such as 4605.8380.
inline constexpr std::string_view kDegreesMinutes = "ddmm";

/// The columns of one quantity. A name is a header's cell with its bracketed unit or without, or a number from 1.
struct ColumnUse {
  std::vector<std::string> names;
  std::string unit = {};  ///< empty: that of the header's brackets
  /// The direction of each column. Of velocities and sigmas: north, east, down, up, south or west. Of an IMU's triads:
  /// the axes of the sensor, such as +x -y -z. Empty: north east down, +x +y +z. Of a latitude or longitude that grows
  /// to the south or west: south or west.
  std::vector<std::string> axes = {};
  /// Of accelerations without gravity: the columns of gravity, which are added. They are those of `gravity_file` if
  /// there is one.
  std::vector<std::string> added = {};
  std::string hemisphere = {};     ///< of latitude or longitude without a sign: the column of N, S, E or W, or empty
  std::string geoid = {};          ///< of a height above the sea: the column of the geoid's height, or empty
  std::vector<double> valid = {};  ///< of `fix`: the values that mean a fix; empty: all above zero
  std::string of = {};             ///< of `quality`: whose numbers they are, nmea or rtklib; empty: words such as FLOAT
  bool operator==(const ColumnUse&) const = default;
};

/// The origin of a time.
enum class TimeScale {
  kBoot,     ///< an unknown instant
  kGpsWeek,  ///< the beginning of the GPS week
  kGps,      ///< 6 January 1980, without leap seconds
  kUtc,      ///< 1 January 1970, without leap seconds, as Unix does
};

/// The column of time. The unit `calendar` is text such as `2020-11-04 09:17:31.4`, of UTC or of GPS time; `hhmmss` is
/// `09:17:31.4` or the number 091731.4, of an unknown day.
struct ColumnTime {
  std::string name;
  std::string unit = {};  ///< empty: that of the header's brackets
  TimeScale of = TimeScale::kBoot;
  std::string week = {};                  ///< the column of the GPS week that goes with seconds of week, or empty
  std::string date = {};                  ///< the column of the date that goes with a time of day, or empty
  std::string rest = {}, rest_unit = {};  ///< a column that is added, such as nanoseconds to seconds, or empty
  bool operator==(const ColumnTime&) const = default;
};

/// The rows of one sensor in a log of several: the rows that have this text in this column.
struct ColumnRows {
  std::string name;  ///< by its number, rows of the other sensors may have any number of fields
  std::string is;
  bool operator==(const ColumnRows&) const = default;
};

/// A quantity that a log may have.
struct ColumnQuantity {
  std::string_view key;
  Dimension dimension;
  std::size_t least, most;  ///< number of columns
};

/// The quantities of an IMU, a receiver, and a reference attitude.
std::span<const ColumnQuantity> imu_quantities();
std::span<const ColumnQuantity> gnss_quantities();
std::span<const ColumnQuantity> attitude_quantities();

/// The whole mapping.
struct ColumnMap {
  ColumnTime time;
  std::vector<ColumnRows> rows = {};                   ///< those that fulfil all of these
  std::optional<ColumnTime> accel_time = {};           ///< of the file of accelerometers, if it differs
  std::vector<ColumnRows> accel_rows = {};             ///< of the file of accelerometers
  std::map<std::string, ColumnUse, std::less<>> uses;  ///< by the keys above
  bool only_new = false;  ///< of a receiver: a row without a position, or with that of the row before, is skipped
  // Estimated from the text if not given:
  std::optional<Delimiter> delimiter = {};
  std::optional<std::size_t> skip = {};  ///< lines before the header, or before the first row
  std::optional<bool> header = {};

  bool operator==(const ColumnMap&) const = default;
  const ColumnUse* find(std::string_view key) const {
    const auto place = uses.find(key);
    return place == uses.end() ? nullptr : &place->second;
  }
};

/// The name of a scale in configurations, such as `boot`.
std::string_view name_of(TimeScale scale);

/// The mapping as the value of the key `columns` in a configuration, in YAML's flow style; each line after the first
/// begins with `indent`.
std::string columns_text(const ColumnMap& map, std::string_view indent);

}  // namespace piste
