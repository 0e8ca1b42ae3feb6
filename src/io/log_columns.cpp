#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <initializer_list>
#include <limits>
#include <numbers>
#include <utility>

#include "core/recording.h"
#include "io/column_reader.h"
#include "io/fix_quality.h"
#include "log_formats.h"
#include "piste/core/error.h"
#include "piste/math/statistics.h"

namespace piste::log_formats {
namespace {

constexpr double kInfinite = std::numeric_limits<double>::infinity();
// Android states accuracies as radii of 68 %. Of the horizontal error, P(radius) = 1 − exp(−radius²/2σ²) gives the
// smaller sigma of each axis. Of single axes, 68 % is one sigma.
const double kRadiusPerSigma = std::sqrt(-2 * std::log(1 - 0.68));

const ColumnQuantity& quantity_named(std::span<const ColumnQuantity> quantities, std::string_view key) {
  for (const ColumnQuantity& q : quantities) {
    if (q.key == key) return q;
  }
  throw ConfigError("", fmt::format("there is no quantity `{}`", key));
}

std::vector<Column> find_columns(const ColumnReader& reader, const ColumnMap& map,
                                 std::span<const ColumnQuantity> quantities, std::string_view key) {
  return reader.columns(map, quantity_named(quantities, key));
}

Vector3d three(const ColumnReader& reader, const std::vector<Column>& columns) {
  return {reader.value(columns[0]), reader.value(columns[1]), reader.value(columns[2])};
}

// The columns of a triad in the order of the sensor's axes, with their signs.
std::vector<Column> along_axes(std::vector<Column> columns, const ColumnUse* use) {
  if (columns.empty() || use->axes.empty()) return columns;
  std::vector<Column> along(columns.size());
  for (std::size_t i = 0; i < columns.size(); ++i) {
    const std::string& axis = use->axes[i];  // such as -y
    along[static_cast<std::size_t>(axis[1] - 'x')] = {columns[i].index, (axis[0] == '-' ? -1 : 1) * columns[i].factor};
  }
  return along;
}

// The columns that an IMU's file has. Of two files each has one triad.
struct ImuColumns {
  std::vector<Column> gyro, accel, gravity, magnetic, temperature;
  bool increments = false;
};

enum class Part { kBoth, kGyro, kAccel, kGravity };

bool has_gyro(Part part) { return part == Part::kBoth || part == Part::kGyro; }

// The mapping of a part: the file of the accelerometers may have a time and rows of its own.
ColumnMap map_of(const ColumnMap& map, Part part) {
  ColumnMap own = map;
  if (has_gyro(part)) return own;
  own.rows = map.accel_rows;
  if (map.accel_time) own.time = *map.accel_time;
  return own;
}

// Whether all these columns are empty: then the row is of another sensor in the same table.
bool is_of_another(const ColumnReader& reader, std::initializer_list<const std::vector<Column>*> all) {
  return std::none_of(all.begin(), all.end(), [&](const std::vector<Column>* columns) {
    return std::any_of(columns->begin(), columns->end(), [&](const Column& c) { return reader.has_value(c); });
  });
}

// Whether one triad of a row is empty and another is not: the slower sensor of a table has values in some rows only.
bool lacks_triad(const ColumnReader& reader, const ImuColumns& columns) {
  return (!columns.gyro.empty() && is_of_another(reader, {&columns.gyro})) ||
         (!columns.accel.empty() && is_of_another(reader, {&columns.accel})) ||
         (!columns.gravity.empty() && is_of_another(reader, {&columns.gravity}));
}

// Whether a row has nothing but zeros, as before the sensor's first sample: no force is none of a body at rest or in
// motion.
bool is_all_zero(const ColumnReader& reader, const ImuColumns& columns) {
  if (columns.gyro.empty() || columns.accel.empty()) return false;
  const auto zero = [&](const Column& c) { return reader.find_value(c) == 0.0; };
  return std::all_of(columns.gyro.begin(), columns.gyro.end(), zero) &&
         std::all_of(columns.accel.begin(), columns.accel.end(), zero) &&
         std::all_of(columns.gravity.begin(), columns.gravity.end(), zero);
}

// `apart`: whether gravity has a file of its own.
ImuColumns imu_columns(const ColumnReader& reader, const ColumnMap& map, Part part, bool apart) {
  const auto find = [&](std::string_view key) {
    return along_axes(find_columns(reader, map, imu_quantities(), key), map.find(key));
  };
  ImuColumns columns;
  columns.increments = map.find("dtheta") != nullptr;
  if (has_gyro(part)) columns.gyro = find(columns.increments ? "dtheta" : "gyro");
  if (part == Part::kBoth || part == Part::kAccel) columns.accel = find(columns.increments ? "dvel" : "accel");
  const ColumnUse* accel = map.find("accel");
  if (accel != nullptr && !accel->added.empty() && (apart ? part == Part::kGravity : part != Part::kGyro)) {
    for (const std::string& name : accel->added)
      columns.gravity.push_back(reader.column(name, "added", accel->unit, dimension::kAcceleration));
    columns.gravity = along_axes(columns.gravity, accel);
  }
  if (!has_gyro(part)) return columns;
  columns.magnetic = find("magnetic");
  columns.temperature = find("temperature");
  return columns;
}

ImuRecording read_part(const LogFile& log, const std::string& file, std::optional<std::string_view> content, Part part,
                       RowFaults* faults) {
  const ColumnMap map = map_of(*log.columns, part);
  ColumnReader reader(file, map, content);
  const ImuColumns columns = imu_columns(reader, map, part, !log.gravity_file.empty());
  ColumnClock clock(reader, map.time, log.order());
  const bool judged = is_for_use(faults) && !columns.gyro.empty() && std::abs(columns.gyro[0].factor) == 1;
  ImuRecording imu;
  imu.file = file;
  imu.increments = columns.increments;
  const auto row = [&] {
    if (is_of_another(reader, {&columns.gyro, &columns.accel, &columns.gravity})) return;
    if (lacks_triad(reader, columns) || is_all_zero(reader, columns)) {
      ++imu.unpaired;
      return;
    }
    const double t = clock.next();
    const auto value = [&](const std::vector<Column>& of) -> Vector3d {
      return of.empty() ? Vector3d::Zero() : three(reader, of);
    };
    const Vector3d gyro = value(columns.gyro), accel = value(columns.accel) + value(columns.gravity),
                   field = value(columns.magnetic);
    const double temperature = columns.temperature.empty() ? 0 : reader.value(columns.temperature[0]);
    if (judged && !imu.increments) check_rate(gyro, reader.text());
    if (judged && imu.increments) check_turn(gyro, t, imu, reader.text());
    imu.time.push_back(t);
    imu.gyro.push_back(gyro);
    imu.accel.push_back(accel);
    constexpr double kMicro = 1e6;
    if (!columns.magnetic.empty()) imu.magnetic.emplace_back(kMicro * field);
    if (!columns.temperature.empty()) imu.temperature.push_back(temperature);
  };
  for_each_row(
      faults, [&] { return reader.next(); }, row);
  return imu;
}

// Accelerations without gravity and gravity, added: rows with the same stamp, as one fusion makes both.
ImuRecording sum_of(const ImuRecording& linear, const ImuRecording& gravity) {
  ImuRecording sum;
  sum.file = linear.file;
  sum.repaired = linear.repaired;
  sum.repaired += gravity.repaired;
  for (std::size_t i = 0, j = 0; i < linear.time.size() && j < gravity.time.size();) {
    if (linear.time[i] == gravity.time[j]) {
      sum.time.push_back(linear.time[i]);
      sum.gyro.push_back(linear.gyro[i]);
      sum.accel.emplace_back(linear.accel[i++] + gravity.accel[j++]);
    } else {
      linear.time[i] < gravity.time[j] ? ++i : ++j;
    }
  }
  constexpr std::size_t kMost = 10;  // rows without a partner: at most one in so many
  sum.unpaired = linear.time.size() + gravity.time.size() - 2 * sum.time.size();
  if (kMost * sum.unpaired > linear.time.size() + gravity.time.size()) {
    throw DataError(gravity.file + ":1",
                    fmt::format("only {} of its {} rows have the time of a row of {}, to which gravity is to be added; "
                                "log the accelerometers' own output",
                                sum.time.size(), gravity.time.size(), linear.file));
  }
  return sum;
}

// The columns of a triad along north, east and down, with their signs. Down is missing if there are two.
struct NedColumns {
  std::array<std::optional<Column>, 3> along;
  bool found() const { return along[0].has_value(); }
};

NedColumns ned_columns(const std::vector<Column>& columns, const ColumnUse* use) {
  NedColumns ned;
  for (std::size_t i = 0; i < columns.size(); ++i) {
    const std::string axis = use->axes.empty() ? std::string() : use->axes[i];
    const bool against = axis == "south" || axis == "west" || axis == "up";
    const std::size_t place = axis.empty()                         ? i
                              : axis == "north" || axis == "south" ? 0
                              : axis == "east" || axis == "west"   ? 1
                                                                   : 2;
    ned.along[place] = {columns[i].index, (against ? -1 : 1) * columns[i].factor};
  }
  return ned;
}

/// Reads fixes row by row.
class FixReader {
 public:
  FixReader(const LogFile& log, const ColumnReader& reader, bool unknown_allowed)
      : log_(log), reader_(reader), unknown_allowed_(unknown_allowed) {
    const ColumnMap& map = *log.columns;
    const auto find = [&](std::string_view key) { return find_columns(reader, map, gnss_quantities(), key); };
    const auto ned = [&](std::string_view key) { return ned_columns(find(key), map.find(key)); };
    place_ = {find("latitude").at(0), find("longitude").at(0), find("height").at(0)};
    sigma_ = ned("sigma");
    covariance_ = find("covariance");
    velocity_ = ned("velocity");
    const auto spread = find("sigma_velocity");
    if (spread.size() == 1) {
      sigma_velocity_.along.fill(spread[0]);
    } else {
      sigma_velocity_ = ned_columns(spread, map.find("sigma_velocity"));
    }
    const auto one = [&](std::string_view key) {
      const auto columns = find(key);
      return columns.empty() ? std::optional<Column>() : columns[0];
    };
    horizontal_ = one("horizontal_accuracy");
    vertical_ = one("vertical_accuracy");
    speed_ = one("speed");
    course_ = one("course");
    speed_accuracy_ = one("speed_accuracy");
    course_accuracy_ = one("course_accuracy");
    fix_ = one("fix");
    quality_ = one("quality");
    for (std::size_t i = 0; i < hemisphere_.size(); ++i) {
      const ColumnUse& use = *map.find(kAngles[i]);
      if (!use.hemisphere.empty()) hemisphere_[i] = reader.place_of(use.hemisphere, "hemisphere");
      minutes_[i] = use.unit == kDegreesMinutes;
      if (!use.axes.empty() && (use.axes[0] == "south" || use.axes[0] == "west")) place_[i].factor *= -1;
    }
    if (const ColumnUse& height = *map.find("height"); !height.geoid.empty()) {
      geoid_ = reader.column(height.geoid, "geoid", height.unit, dimension::kLength);
    }
  }

  /// Whether a row has a place, and whether it is that of the row with a place before: the fastest sensor makes the
  /// rows of a log of several. A height or a speed that changes alone is no new fix: parsers set each as it comes.
  enum class Place { kNone, kSame, kNew };
  Place place() {
    std::array<double, 2> now{};
    for (std::size_t i = 0; i < place_.size(); ++i) {
      const auto value = reader_.find_value(place_[i]);
      if (!value) return Place::kNone;
      if (i < now.size()) now[i] = *value;
    }
    for (std::size_t i = 0; i < now.size(); ++i) changed_[i] = !last_ || (*last_)[i] != now[i];
    return std::exchange(last_, now) == now ? Place::kSame : Place::kNew;
  }

  /// Which of latitude and longitude made the last new place.
  using Changed = std::array<bool, 2>;
  const Changed& changed() const { return changed_; }

  /// Whether the receiver says that it has a fix: by the column `fix`, by an accuracy above zero, as iOS and
  /// Android, and by a place that is there.
  bool has_fix() const {
    if (fix_) {
      const auto value = reader_.find_value(*fix_);
      const std::vector<double>& valid = log_.columns->find("fix")->valid;
      if (!value || (valid.empty() ? !(*value > 0) : std::find(valid.begin(), valid.end(), *value) == valid.end())) {
        return false;
      }
    }
    if (quality_ && !quality()) return false;
    const auto radius = horizontal_ ? reader_.find_value(*horizontal_) : std::nullopt;
    if (radius && !(*radius > 0)) return false;
    for (const Column& c : place_) {
      if (!reader_.find_value(c)) return false;
    }
    return has_coordinates(reader_.value(place_[0]), reader_.value(place_[1]));
  }

  GeodeticFix fix(double time) const {
    GeodeticFix fix;
    fix.time = time;
    fix.position = {angle(0), angle(1), reader_.value(place_[2]) + (geoid_ ? reader_.value(*geoid_) : 0)};
    fix.sigma_position = sigma();
    if (quality_) fix.quality = quality().value_or(FixQuality::kUnknown);
    if (!covariance_.empty() && !log_.sigma) fix.correlation = correlations(covariance());
    if (velocity_.found()) fix.velocity = velocity();
    if (speed_) fix.velocity = velocity_along_course();
    check_fix(fix, log_, reader_.text());
    return fix;
  }

 private:
  // Nothing where the receiver says that there is no fix, or none that it measured.
  std::optional<FixQuality> quality() const {
    const std::string& of = log_.columns->find("quality")->of;
    if (of.empty()) return quality_of_word(reader_.text().fields()[quality_->index]);
    const auto number = reader_.find_value(*quality_);
    if (!number) return std::nullopt;
    return of == "nmea" ? quality_of_nmea(*number) : quality_of_rtklib(*number);
  }

  static constexpr std::array<std::string_view, 2> kAngles{"latitude", "longitude"};

  // Of degrees and minutes as one number, in degrees as it was read: 46° 5.838' are 4605.838.
  double of_minutes(double value) const {
    constexpr double kHundred = 100, kMinutes = 60;
    const double digits = std::abs(value / kDegree), degrees = std::floor(digits / kHundred);
    const double minutes = digits - kHundred * degrees;
    if (!(minutes < kMinutes)) {
      reader_.text().fail(fmt::format("{} has {:.4f} minutes of arc; are these degrees and minutes as NMEA has them?",
                                      digits, minutes));
    }
    return std::copysign(degrees + minutes / kMinutes, value) * kDegree;
  }

  // Latitude or longitude, with the sign of its hemisphere.
  double angle(std::size_t i) const {
    double value = reader_.value(place_[i]);
    if (minutes_[i]) value = of_minutes(value);
    if (!hemisphere_[i]) return value;
    const std::string_view letter = reader_.text().fields()[*hemisphere_[i]];
    const std::string_view positive = i == 0 ? "Nn" : "Ee", negative = i == 0 ? "Ss" : "Ww";
    const bool known = letter.size() == 1 && (positive.find(letter) != std::string_view::npos ||
                                              negative.find(letter) != std::string_view::npos);
    if (!known || value < 0) {
      reader_.text().fail(fmt::format("`{}` is no hemisphere of the {} {:.7f} deg; right would be {} or {} with an "
                                      "angle without a sign",
                                      letter, kAngles[i], value / kDegree, positive[0], negative[0]),
                          RowFault::Kind::kText);
    }
    return negative.find(letter) != std::string_view::npos ? -value : value;
  }

  Vector3d sigma() const {
    if (log_.sigma) return *log_.sigma;
    if (!covariance_.empty()) return covariance().diagonal().cwiseMax(0).cwiseSqrt();
    if (sigma_.found()) {
      Vector3d sigma;
      for (int i = 0; i < 3; ++i) sigma(i) = std::abs(needed(sigma_.along[static_cast<std::size_t>(i)]));
      return sigma;
    }
    if (!horizontal_ && unknown_allowed_) return unknown_sigma();
    const double across = needed(horizontal_) / kRadiusPerSigma;
    return {across, across, needed(vertical_)};
  }

  // Along north, east and down.
  Matrix3d covariance() const {
    Matrix3d own, turn = Matrix3d::Zero();
    for (int i = 0; i < 9; ++i) own(i / 3, i % 3) = needed(covariance_[static_cast<std::size_t>(i)]);
    const NedColumns along = ned_columns({{0, 1}, {1, 1}, {2, 1}}, log_.columns->find("covariance"));
    for (Eigen::Index i = 0; i < 3; ++i) {
      const Column& axis = *along.along[static_cast<std::size_t>(i)];
      turn(i, static_cast<Eigen::Index>(axis.index)) = axis.factor;
    }
    return turn * own * turn.transpose();
  }

  double needed(const std::optional<Column>& column) const {
    const auto value = column ? reader_.find_value(*column) : std::nullopt;
    if (value) return *value;
    reader_.text().fail("no sigma in this row; `sigma: 3 3 6 m` in the configuration states one for all",
                        RowFault::Kind::kText);
  }

  // Nothing if a value is missing.
  std::optional<FixVelocity> velocity() const {
    FixVelocity v{Vector3d::Zero(), Vector3d::Constant(kInfinite)};
    for (std::size_t i = 0; i < 3; ++i) {
      if (!velocity_.along[i]) continue;
      const auto value = reader_.find_value(*velocity_.along[i]);
      const auto& spread = sigma_velocity_.along[i];
      const auto sigma = spread            ? reader_.find_value(*spread)
                         : speed_accuracy_ ? reader_.find_value(*speed_accuracy_)
                                           : std::nullopt;
      if (!value || ((!sigma || *sigma == 0) && !log_.sigma_velocity)) return std::nullopt;
      v.value(static_cast<Eigen::Index>(i)) = *value;
      v.sigma(static_cast<Eigen::Index>(i)) =
          log_.sigma_velocity ? (*log_.sigma_velocity)(static_cast<Eigen::Index>(i)) : std::abs(*sigma);
    }
    return v;
  }

  // The error along the course is that of the speed, and across it speed times that of the course. Both horizontal axes
  // get the larger: an ellipse along other axes cannot be stated, and no direction gets a sigma that is too small. A
  // course without accuracy comes from the velocities, with errors as large across as along.
  std::optional<FixVelocity> velocity_along_course() const {
    constexpr double kNone = -10;  // negative values are iOS' sign that there is none
    const auto value = [&](const std::optional<Column>& column) {
      return column ? reader_.find_value(*column).value_or(kNone) : kNone;
    };
    const double speed = value(speed_), course = value(course_), along = value(speed_accuracy_);
    const bool no_course = course < -std::numbers::pi || course == -kDegree;
    if (speed < 0 || no_course || (along < 0 && !log_.sigma_velocity)) return std::nullopt;
    const double sigma = std::max({along, speed * value(course_accuracy_), 0.0});
    if (sigma == 0 && !log_.sigma_velocity) return std::nullopt;
    if (!std::isfinite(sigma))
      reader_.text().fail("the sigma of the velocity is not finite", RowFault::Kind::kNotFinite);
    return FixVelocity{{speed * std::cos(course), speed * std::sin(course), 0}, {sigma, sigma, kInfinite}};
  }

  const LogFile& log_;
  const ColumnReader& reader_;
  bool unknown_allowed_;
  std::array<Column, 3> place_;
  std::array<std::optional<std::size_t>, 2> hemisphere_;
  std::array<bool, 2> minutes_{};
  std::optional<Column> geoid_;
  std::optional<std::array<double, 2>> last_;
  Changed changed_{};
  NedColumns sigma_, velocity_, sigma_velocity_;
  std::vector<Column> covariance_;
  std::optional<Column> horizontal_, vertical_, speed_, course_, speed_accuracy_, course_accuracy_, fix_, quality_;
};

/// The rows of a log that repeat the last fix.
struct HeldRows {
  std::size_t settled = 0;  ///< half the usual number of rows from one new place to the next
  /// Rows within which the second coordinate of a fix follows the first one; 0 if both change in one row.
  std::size_t apart = 0;
};

// Whether one coordinate made the one place, and the other coordinate the other.
bool are_other(const FixReader::Changed& one, const FixReader::Changed& other) {
  return one[0] != one[1] && other[0] == one[1] && other[1] == one[0];
}

/// Takes one fix of the rows that repeat it. Its time is that of the first of them. A logger may set place, height and
/// speed in different rows, as sentences arrive: the other values are those half-way to the next place, where all of
/// one fix and none of the next have arrived.
class HeldFixes {
 public:
  HeldFixes(FixReader& fixes, ColumnClock& clock, HeldRows rows, GnssRecording& gnss)
      : fixes_(fixes), clock_(clock), rows_(rows), gnss_(gnss) {}

  void row() {
    FixReader::Place place = fixes_.place();
    if (place == FixReader::Place::kNew && time_ && age_ < rows_.apart && are_other(first_, fixes_.changed()))
      place = FixReader::Place::kSame;
    if (place != FixReader::Place::kSame) end();
    if (place == FixReader::Place::kNone) return;
    if (place == FixReader::Place::kNew) {
      if (!fixes_.has_fix()) {
        ++gnss_.without_fix;
        return;
      }
      age_ = 0;
      first_ = fixes_.changed();
      time_ = clock_.next();
    } else if (!time_ || ++age_ > rows_.settled) {
      return;
    }
    const double time = *std::exchange(time_, std::nullopt);  // a row that cannot be read ends the fix
    fix_ = fixes_.fix(time);
    time_ = time;
  }

  /// Ends the fix of the rows before.
  void end() {
    if (fix_) gnss_.fixes.push_back(*fix_);
    fix_.reset();
    time_.reset();
  }

 private:
  FixReader& fixes_;
  ColumnClock& clock_;
  HeldRows rows_;
  std::size_t age_ = 0;
  FixReader::Changed first_{};
  GnssRecording& gnss_;
  std::optional<double> time_;
  std::optional<GeodeticFix> fix_;
};

// Each new place of a log: the rows since the one before, and what made it.
struct NewPlace {
  std::size_t rows;
  FixReader::Changed changed;
};

std::vector<NewPlace> new_places(const LogFile& log) {
  ColumnReader reader(log.file, *log.columns, log.content);
  FixReader fixes(log, reader, true);
  std::vector<NewPlace> places;
  std::size_t rows = 0;
  RowFaults unreadable;
  for_each_row(
      &unreadable, [&] { return reader.next(); },
      [&] {
        const FixReader::Place place = fixes.place();
        if (place == FixReader::Place::kNew && rows > 0) places.push_back({rows, fixes.changed()});
        if (place != FixReader::Place::kSame) rows = 0;
        if (place != FixReader::Place::kNone) ++rows;
      });
  return places;
}

HeldRows held_rows(const LogFile& log) {
  std::vector<NewPlace> places = new_places(log);
  if (places.empty()) return {};
  HeldRows held;
  std::vector<double> behind;  // rows from one coordinate to the other, where a place of both halves follows
  for (std::size_t k = 1; k < places.size(); ++k) {
    if (are_other(places[k - 1].changed, places[k].changed) && 2 * places[k].rows < places[k - 1].rows)
      behind.push_back(static_cast<double>(places[k].rows));
  }
  constexpr std::size_t kMostly = 3;  // of the new places, every second one: two in six, where some change in one row
  if (kMostly * behind.size() > places.size()) held.apart = static_cast<std::size_t>(median(std::move(behind))) + 1;
  std::vector<double> lengths;
  double length = 0;
  for (std::size_t k = 0; k < places.size(); ++k) {
    length += static_cast<double>(places[k].rows);
    if (k > 0 && places[k].rows <= held.apart && are_other(places[k - 1].changed, places[k].changed)) continue;
    lengths.push_back(std::exchange(length, 0.0));
  }
  held.settled = static_cast<std::size_t>(median(std::move(lengths)) / 2);
  return held;
}

}  // namespace

ImuRecording read_imu_columns(const LogFile& log, RowFaults* faults) {
  if (log.accel_file.empty()) return read_part(log, log.file, log.content, Part::kBoth, faults);
  ImuRecording gyro = read_part(log, log.file, log.content, Part::kGyro, faults);
  if (log.as_it_stands) return gyro;
  ImuRecording accel = read_part(log, log.accel_file, {}, Part::kAccel, faults);
  if (!log.gravity_file.empty()) accel = sum_of(accel, read_part(log, log.gravity_file, {}, Part::kGravity, faults));
  take_out_steps(gyro, log);
  take_out_steps(accel, log);
  if (log.shared_stamps) {
    spread_stamps(gyro);
    spread_stamps(accel);
  }
  if (log.repair) {
    repair_rows(gyro);
    repair_rows(accel);
  }
  if (log.even_stamps) {
    even_stamps(gyro);
    even_stamps(accel);
  }
  return paired(gyro, accel, log.instant);
}

GnssRecording read_gnss_columns(const LogFile& log, RowFaults* faults) {
  ColumnReader reader(log.file, *log.columns, log.content);
  FixReader fixes(log, reader, !is_for_use(faults));
  ColumnClock clock(reader, log.columns->time, log.order());
  GnssRecording gnss;
  gnss.file = log.file;
  if (log.columns->only_new) {
    HeldFixes held(fixes, clock, held_rows(log), gnss);
    for_each_row(
        faults, [&] { return reader.next(); }, [&] { held.row(); });
    held.end();
    return gnss;
  }
  const auto row = [&] {
    if (!fixes.has_fix()) {
      ++gnss.without_fix;
      return;
    }
    gnss.fixes.push_back(fixes.fix(clock.next()));
  };
  for_each_row(
      faults, [&] { return reader.next(); }, row);
  return gnss;
}

AttitudeRecording read_attitude_columns(const LogFile& log, RowFaults* faults) {
  const ColumnMap& map = *log.columns;
  ColumnReader reader(log.file, map, log.content);
  const auto angles = find_columns(reader, map, attitude_quantities(), "angles");
  const auto sigma = find_columns(reader, map, attitude_quantities(), "sigma");
  ColumnClock clock(reader, map.time, log.order());
  AttitudeRecording attitude;
  attitude.file = log.file;
  const auto row = [&] {
    if (is_of_another(reader, {&angles})) return;
    EulerFix fix{clock.next(), three(reader, angles), sigma.empty() ? unknown_sigma() : three(reader, sigma)};
    check_attitude(fix, log, reader.text());
    attitude.fixes.push_back(fix);
  };
  for_each_row(
      faults, [&] { return reader.next(); }, row);
  return attitude;
}

}  // namespace piste::log_formats
