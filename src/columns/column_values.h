#pragma once
/// Quantity and unit of columns by their values.

#include <array>
#include <span>
#include <string>
#include <vector>

#include "column_table.h"

namespace piste {

using ColumnTriad = std::array<std::size_t, 3>;

/// Median of the magnitudes of three columns; NaN without rows.
double usual_magnitude(const ColumnTable& table, const ColumnTriad& triad);

/// By how much the magnitudes differ from the usual one, as a part of it: their median.
double magnitude_scatter(const ColumnTable& table, const ColumnTriad& triad);

/// A unit that values suggest, and a note for the user if it is uncertain.
struct UnitGuess {
  std::string unit;
  std::string doubt = {};
  bool is_counts = false;
};

/// The unit in which this magnitude is that of gravity, such as `m/s^2`; for raw counts it has a number.
UnitGuess gravity_unit(double magnitude);
/// Whether that is one of the units that sensors have.
bool is_gravity(double magnitude);
/// Whether three columns are as large as gravity, also in the quietest moments: accelerations without it are small
/// then.
bool holds_gravity(const ColumnTable& table, const ColumnTriad& triad);

/// The unit of gyroscopes whose output is raw counts, before their motion determines it.
UnitGuess turn_counts();
/// The scales that sensors have [(deg/s) / count].
std::span<const double> count_units();

/// The unit of gyroscopes: by their largest values, and by the noise in the quietest moments.
UnitGuess turn_unit(const ColumnTable& table, const ColumnTriad& triad);

/// How steadily a column increases.
struct Steps {
  double median = 0;      ///< of the steps that increase; 0 if there are none
  double mean = 0;        ///< of all
  double increasing = 0;  ///< part of the steps that increase
  double backwards = 0;   ///< part of the steps that decrease
  double lost = 0;        ///< by what it decreases, as a part of that by which it increases
  std::size_t falls = 0;  ///< number of steps that decrease
  double first = 0;       ///< the first value
  bool whole = true;      ///< whether all values are whole numbers
  /// Whether it is the fraction of a unit that another column counts: it starts again and again. A log may start again
  /// once or twice, and single rows may come late.
  bool falls_back() const { return falls > 2 && lost > 0.5; }
  bool is_time() const { return is_coarse_time() && increasing > 0.5; }
  /// The same for a column whose value most rows share with the row before.
  bool is_coarse_time() const { return median > 0 && backwards < 0.02 && !falls_back(); }
};
/// `values` are a column's, or as many.
Steps steps_of(const ColumnTable& table, const std::vector<double>& values);

/// Part of the rows of a column in which its text is not that of the row before.
double changing(const ColumnTable& table, const SampledColumn& column);

/// Whether values are times of day as digits, such as 91731.4 for 9:17:31.4. Minutes and seconds are below 60, and the
/// value leaps by 40 where a minute ends.
bool is_time_of_day(const ColumnTable& table, const std::vector<double>& values);

/// The intervals between the rows of a kind of log [s].
struct Pace {
  double usual, fastest, slowest;
};

/// The unit of a time: that in which it is a time since 1970 at a possible pace, or else runs at the usual one.
std::string time_unit(const Steps& steps, const Pace& pace);

/// The headerless triads: specific force, and gyroscopes next to it. Nothing if no three columns are like gravity.
struct ValueTriads {
  ColumnTriad accel, gyro;
};
std::optional<ValueTriads> find_triads(const ColumnTable& table, std::size_t time);

/// The columns of a position without a header: two neighbours that change by a small part of themselves from row to
/// row, as latitude and longitude do, and the next column that changes. Nothing if there are none.
struct ValuePlace {
  std::size_t latitude, longitude, height;
};
std::optional<ValuePlace> find_place(const ColumnTable& table, std::size_t time);

}  // namespace piste
