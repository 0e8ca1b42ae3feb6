#include "column_guess.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <filesystem>
#include <iterator>
#include <numbers>

#include "column_names.h"
#include "column_table.h"
#include "column_time.h"
#include "column_units.h"
#include "column_values.h"
#include "declared_columns.h"
#include "io/fix_quality.h"
#include "io/lower_case.h"
#include "piste/core/error.h"
#include "row_kinds.h"
#include "tagged_rows.h"

namespace piste {
namespace {

constexpr double kRightAngle = 90;  // deg
constexpr std::string_view kEarthCentred =
    "metres from the middle of the Earth (ECEF), which piste does not read: convert them to latitude, longitude and "
    "height, such as with out-solformat=llh in RTKLIB,";

// Days since power-up in one unit look like a time since 1970 in the next, at a thousandth of the pace. The limits are
// such that an IMU of 1 kHz and a receiver of 20 Hz are not mistaken, and an IMU of 2 Hz and a receiver with a fix
// every half minute are accepted.
constexpr Pace kImuPace{.usual = 0.01, .fastest = 5e-5, .slowest = 0.6};
constexpr Pace kGnssPace{.usual = 0.5, .fastest = 1e-3, .slowest = 40};
constexpr Pace kAttitudePace{.usual = 0.01, .fastest = 1e-4, .slowest = 5};

/// Builds the mapping of one table.
class Guesser {
 public:
  using Part = LogGuess::Part;

  /// `name`: of the file, or of the sensor whose rows these are. `part`: the part that is looked for.
  Guesser(std::string file, std::string_view name, const ColumnTable& table, Part part = Part::kWhole)
      : file_(std::move(file)), name_(lower_case(name)), table_(table), part_(part) {
    for (const SampledColumn& column : table.columns) meanings_.push_back(meaning_of(column));
  }

  std::optional<LogGuess> guess() {
    refuse_earth_centred();
    refuse_text_of_places();
    if (one("latitude") && one("longitude")) return with_body(receiver_alone());
    if (!table_.header && !has_triads_by_values()) {
      if (auto places = receiver_by_values()) return places;
    }
    if (auto imu = imu_alone()) return imu;
    if (one("roll") && one("pitch") && (one("heading") || one("course"))) return attitude();
    return std::nullopt;
  }

 private:
  // ---- Finding columns ----

  bool has_body() const { return (triad("gyro") && triad("accel")) || (triad("dtheta") && triad("dvel")); }

  ColumnTable rows_of_places() const {
    const std::array<std::size_t, 2> place{*one("latitude"), *one("longitude")};
    return table_.rows_with(place);
  }

  // The receiver's log, of the rows that have a place: those of other sensors may have none.
  std::optional<LogGuess> receiver_alone() const {
    const ColumnTable rows = rows_of_places();
    if (rows.rows == 0 && has_body()) return std::nullopt;
    const bool fewer = 2 * rows.rows < table_.rows;
    return Guesser(file_, name_, rows.rows > 2 ? rows : table_).receiver(has_body() && !fewer ? kImuPace : kGnssPace);
  }

  // Whether a table without a header has the triads of an IMU, none of it in whole numbers as those of satellites.
  bool has_triads_by_values() const {
    Guesser other(file_, name_, table_);
    if (!other.find_time(kImuPace)) return false;
    const auto triads = find_triads(table_, other.time_column_);
    const auto broken = [&](const ColumnTriad& t) {
      return std::none_of(t.begin(), t.end(), [&](std::size_t c) { return table_.columns[c].is_whole(); });
    };
    return triads && broken(triads->gyro) && broken(triads->accel);
  }

  // Whether a time only counts the rows, while another column is a year.
  bool counts_rows_of_dates(std::size_t time) const {
    constexpr double kFirstYear = 1980, kLastYear = 2100;
    const auto& rows = table_.columns[time].values;
    for (std::size_t i = 1; i < rows.size(); ++i) {
      if (!table_.begins(i) && rows[i] - rows[i - 1] != 1) return false;
    }
    return std::any_of(table_.columns.begin(), table_.columns.end(), [&](const SampledColumn& c) {
      return !c.values.empty() && c.is_whole() && c.values[0] >= kFirstYear && c.values[0] < kLastYear &&
             changing(table_, c) < 1e-3;
    });
  }

  // The receiver's log of a table without a header.
  std::optional<LogGuess> receiver_by_values() const {
    Guesser other(file_, name_, table_);
    if (!other.find_time(kGnssPace)) return std::nullopt;
    const auto place = find_place(table_, other.time_column_);
    if (!place) return std::nullopt;
    if (counts_rows_of_dates(other.time_column_)) {
      throw DataError(
          file_ + ":1",
          fmt::format("has places without a header, a column {} that counts the rows, and a date in columns "
                      "of its own; put names such as time,latitude,longitude,height above, with one column "
                      "of time such as 2024-02-07 12:17:42.1",
                      table_.name_of(other.time_column_)));
    }
    other.meanings_[place->latitude] = {"latitude", 0, {}};
    other.meanings_[place->longitude] = {"longitude", 0, {}};
    other.meanings_[place->height] = {"height", 0, {}};
    other.doubts_.emplace_back("columns: found by their values alone, as there is no header: check them");
    auto guess = other.receiver(kGnssPace);
    if (guess) guess->why = "two columns that change as those of a place do";
    return guess;
  }

  // The IMU's log, of the rows that have its values. Gyroscopes and accelerometers with rows of their own are two
  // parts, as in two files.
  std::optional<LogGuess> imu_alone() const {
    const auto gyro = triad("gyro"), accel = forces();
    if (!gyro || !accel) return Guesser(file_, name_, table_).imu();
    const ColumnTable turns = table_.rows_with(*gyro), both = turns.rows_with(*accel),
                      pushes = table_.rows_with(*accel);
    if (turns.rows == 0 && pushes.rows == 0 && one("latitude")) return std::nullopt;
    if (2 * both.rows >= turns.rows || 2 * both.rows >= pushes.rows) {
      return Guesser(file_, name_, both.rows > 2 ? both : table_).imu();
    }
    auto guess = Guesser(file_, name_, turns, Part::kGyro).imu();
    auto accel_part = Guesser(file_, name_, pushes, Part::kAccel).imu();
    if (guess && accel_part) guess->beside.push_back(std::move(*accel_part));
    return guess;
  }

  // The log of the IMU in the columns next to those of a receiver, whose rows are then those of the IMU.
  std::optional<LogGuess> with_body(std::optional<LogGuess> receiver) const {
    if (!has_body()) return receiver;
    auto body = Guesser(file_, name_, table_).imu_alone();
    if (!body) return receiver;
    if (receiver) {
      receiver->columns->only_new = true;
      // Where rows of the IMU repeat the last fix, the logger's time is not that of the fix.
      const bool own_rows = 2 * rows_of_places().rows < table_.rows;
      const bool stamped = receiver->columns->time.of != TimeScale::kBoot;
      const bool own_stamps = own_rows || (stamped && receiver->columns->time != body->columns->time);
      if (stamped && body->columns->time.of == TimeScale::kBoot) receiver->boot_time = body->columns->time;
      if (!own_stamps || receiver->boot_time != body->columns->time) receiver->boot_time.reset();
      receiver->why += ", next to those of an IMU: each new place is a fix";
      body->beside.push_back(std::move(*receiver));
    } else {
      body->lost = "the columns of a receiver are not used: it has no place in them, or none is known for its height";
    }
    return body;
  }

  std::optional<std::size_t> one(std::string_view key) const { return column_of(meanings_, key); }

  // The columns of the first group of this key, or of the named one, that has all these axes.
  std::optional<std::vector<std::size_t>> group(std::string_view key, std::string_view axes,
                                                const std::optional<std::string>& named = {}) const {
    for (const ColumnMeaning& first : meanings_) {
      if (first.key != key || first.axis == 0 || (named && first.group != *named)) continue;
      std::vector<std::size_t> found;
      for (const char axis : axes) {
        for (std::size_t c = 0; c < meanings_.size(); ++c) {
          const ColumnMeaning& m = meanings_[c];
          if (m.key == key && m.axis == axis && m.group == first.group) {
            found.push_back(c);
            break;
          }
        }
      }
      if (found.size() == axes.size()) return found;
    }
    return std::nullopt;
  }

  std::optional<ColumnTriad> triad(std::string_view key) const {
    const auto found = group(key, "xyz");
    if (!found) return std::nullopt;
    return ColumnTriad{(*found)[0], (*found)[1], (*found)[2]};
  }

  // Of several triads of accelerometers the one with gravity: accelerations of a sensor fusion may be in the same log.
  std::optional<ColumnTriad> forces() const {
    const auto first = triad("accel");
    for (const ColumnMeaning& m : meanings_) {
      if (m.key != "accel" || m.axis != 'x') continue;
      const auto found = group("accel", "xyz", m.group);
      if (!found) continue;
      const ColumnTriad t{(*found)[0], (*found)[1], (*found)[2]};
      if (holds_gravity(table_, t)) return t;
    }
    return first;
  }

  // Accelerations without gravity, `known` or named so, where a fusion also logs gravity.
  std::optional<ColumnTriad> parted_force(const std::optional<ColumnTriad>& known) const {
    const auto linear = known ? known : triad("linear"), gravity = triad("gravity");
    const bool adds_up = linear && gravity && is_gravity(usual_magnitude(table_, *gravity));
    return adds_up ? linear : std::nullopt;
  }

  // ---- Writing them down ----

  bool has_unit(std::size_t column, const Dimension& dimension) const {
    return piste::has_unit(table_, column, dimension);
  }

  ColumnUse& use(std::string_view key, const std::vector<std::size_t>& columns, const Dimension& dimension,
                 const std::string& else_unit) {
    ColumnUse& entry = map_.uses[std::string(key)];
    for (const std::size_t c : columns) entry.names.push_back(table_.name_of(c));
    if (dimension == dimension::kRatio) return entry;
    entry.unit = unit_of(table_, columns[0], dimension, else_unit);
    const bool all = std::all_of(columns.begin(), columns.end(),
                                 [&](std::size_t c) { return has_known_brackets(table_, c, dimension); });
    if (entry.unit.empty() && !all) entry.unit = table_.columns[columns[0]].cell.unit;
    return entry;
  }

  void use_triad(std::string_view key, const ColumnTriad& t, const Dimension& dimension, const UnitGuess& unit) {
    ColumnUse& entry = use(key, {t[0], t[1], t[2]}, dimension, unit.unit);
    if (!table_.columns[t[0]].along.empty()) {
      for (const std::size_t c : t) entry.axes.push_back(table_.columns[c].along);
    }
    if (!unit.doubt.empty() && !has_unit(t[0], dimension)) doubts_.push_back(fmt::format("{}: {}", key, unit.doubt));
  }

  LogGuess taken(LogKind kind, LogGuess::Part part, const std::string& why) {
    LogGuess guess;
    guess.kind = kind;
    guess.format = LogFormat::kColumns;
    guess.why = why;
    guess.columns = map_;
    guess.part = part;
    guess.boot_time = boot_;
    guess.doubts = doubts_;
    guess.guessed_rates = guessed_rates_;
    return guess;
  }

  // `of`: a column of the sensor, whose own stamp is preferred.
  bool find_time(const Pace& pace, std::optional<std::size_t> of = {}) {
    const bool named = of && table_.columns[*of].words.size() > 1;
    auto found = piste::find_time(file_, table_, meanings_, pace, named ? table_.columns[*of].words.front() : "");
    if (!found) return false;
    map_.time = std::move(found->time);
    time_column_ = found->column;
    boot_ = std::move(found->boot);
    return true;
  }

  [[noreturn]] void lacks(std::string_view quantity, std::string_view others) const {
    throw DataError(
        file_ + ":1",
        fmt::format("has columns of {}, and none that is known for the {}; name it so in the header, such as "
                    "`{}`",
                    others, quantity, quantity == "time" ? "time_s" : "height_m"));
  }

  // Three columns as long as the way from the middle of the Earth are a place in ECEF.
  void refuse_earth_centred() const {
    if (one("latitude") || has_body()) return;
    const auto unknown = [&](std::size_t c) { return meanings_[c].key.empty() || meanings_[c].key == "axis"; };
    for (std::size_t c = 0; c + 2 < table_.columns.size(); ++c) {
      if (!unknown(c) || !unknown(c + 1) || !unknown(c + 2) || !is_earth_centred({c, c + 1, c + 2})) continue;
      throw DataError(file_ + ":1", fmt::format("has places as {} in columns {}, {} and {}", kEarthCentred,
                                                table_.name_of(c), table_.name_of(c + 1), table_.name_of(c + 2)));
    }
  }

  bool is_earth_centred(const ColumnTriad& t) const {
    constexpr double kNearest = 6.3e6, kFarthest = 6.5e6;  // m from the middle of the Earth
    constexpr double kFarOff = 1e5;                        // two of three are, but for a counter with small numbers
    const double length = usual_magnitude(table_, t);
    return length > kNearest && length < kFarthest &&
           std::count_if(t.begin(), t.end(), [&](std::size_t c) { return largest(c) > kFarOff; }) > 1;
  }

  // Places in words, such as 46° 30.1' N, are no numbers in any row.
  void refuse_text_of_places() const {
    for (const std::string_view key : {"latitude", "longitude"}) {
      const auto column = one(key);
      if (!column || table_.rows < 2) continue;
      const SampledColumn& c = table_.columns[*column];
      const bool number = std::any_of(c.values.begin(), c.values.end(), [](double v) { return std::isfinite(v); });
      if (number || c.first().empty()) continue;
      throw DataError(file_ + ":1",
                      fmt::format("has no number in its column `{}`, but text such as `{}`; write degrees "
                                  "with a point, such as 46.0973 or -7.2286, negative in the south and "
                                  "the west",
                                  table_.name_of(*column), c.first()));
    }
  }

  // ---- Kinds ----

  std::optional<LogGuess> imu() {
    auto gyro = part_ == Part::kAccel ? std::nullopt : triad("gyro");
    auto accel = part_ == Part::kGyro ? std::nullopt : forces();
    if (part_ != Part::kGyro && (!accel || !holds_gravity(table_, *accel))) {
      if (const auto sum = parted_force(accel)) {
        accel = sum;
        added_ = triad("gravity");
      }
    }
    const auto dtheta = triad("dtheta"), dvel = triad("dvel");
    const bool increments = dtheta && dvel && !(gyro && accel);
    const auto plain = triad("axis");
    if (!gyro && !accel && !increments && table_.header) {
      if (triad("magnetic")) return put_aside("of a magnetometer alone");
      if (!plain) return std::nullopt;
      if (const std::string why = why_no_body(*plain); !why.empty()) return put_aside(why);
    }
    const std::optional<ColumnTriad>& stamped = gyro ? gyro : accel;
    if (!find_time(kImuPace, stamped ? std::optional((*stamped)[0]) : std::nullopt)) {
      if (table_.rows > 2 && table_.header && (increments || (gyro && accel))) lacks("time", "an IMU");
      return std::nullopt;
    }
    boot_.reset();
    std::string why = "columns named as those of an IMU";
    if (increments) {
      use_triad("dtheta", *dtheta, dimension::kAngle, {"rad"});
      use_triad("dvel", *dvel, dimension::kVelocity, {"m/s"});
      return taken(LogKind::kImu, LogGuess::Part::kWhole, why);
    }
    if (!gyro && !accel && plain) {
      const bool forces = is_of_forces(*plain);
      (forces ? accel : gyro) = plain;
      why = fmt::format("columns x, y, z of {}", forces ? "accelerometers" : "gyroscopes");
    }
    if (!gyro && !accel && !table_.header && table_.columns.size() == 4) {
      const ColumnTriad only = columns_without_time();
      if (named_gyroscopes() || is_of_forces(only)) {
        (named_gyroscopes() ? gyro : accel) = only;
        why = fmt::format("four columns without names, and the name of the {}", gyro ? "gyroscopes" : "accelerometers");
      }
    }
    if (!gyro && !accel) {
      const auto found = find_triads(table_, time_column_);
      if (!found) return std::nullopt;
      gyro = found->gyro;
      accel = found->accel;
      why = "three columns as large as gravity, three others, and one that increases evenly";
      doubts_.emplace_back("columns: found by their values alone, as there is no header: check them");
    }
    const bool counts = use_force(accel);
    if (gyro) {
      UnitGuess unit = turn_unit(table_, *gyro);
      guessed_rates_ = !has_unit((*gyro)[0], dimension::kAngularRate) && !counts;
      if (counts && is_whole(*gyro)) unit = turn_counts();
      use_triad("gyro", *gyro, dimension::kAngularRate, unit);
    }
    if (const auto magnetic = triad("magnetic");
        magnetic && gyro && has_unit((*magnetic)[0], dimension::kMagneticField)) {
      use_triad("magnetic", *magnetic, dimension::kMagneticField, {""});
    }
    if (accel && gyro) return taken(LogKind::kImu, LogGuess::Part::kWhole, why);
    LogGuess part = taken(LogKind::kImu, accel ? LogGuess::Part::kAccel : LogGuess::Part::kGyro, why);
    if (accel && !added_) {
      part.part = part_of_force(*accel);
      part.aside = why_no_force(part.part, *accel);
    }
    if (!accel && named("uncal")) part.aside = "uncalibrated, as its name says";
    return part;
  }

  // Writes the accelerometers down. Returns whether they are raw counts.
  bool use_force(const std::optional<ColumnTriad>& accel) {
    if (!accel) return false;
    const UnitGuess unit = gravity_unit(usual_magnitude(table_, added_ ? *added_ : *accel));
    use_triad("accel", *accel, dimension::kAcceleration, unit);
    for (const std::size_t c : added_.value_or(ColumnTriad{})) {
      if (added_) map_.uses["accel"].added.push_back(table_.name_of(c));
    }
    return unit.is_counts && is_whole(*accel) && !has_unit((*accel)[0], dimension::kAcceleration);
  }

  bool is_whole(const ColumnTriad& t) const {
    return std::all_of(t.begin(), t.end(), [&](std::size_t c) { return table_.columns[c].is_whole(); });
  }

  // The three columns of four that are not the time.
  ColumnTriad columns_without_time() const {
    ColumnTriad t{};
    for (std::size_t c = 0, k = 0; k < t.size(); ++c) {
      if (c != time_column_) t[k++] = c;
    }
    return t;
  }

  static LogGuess put_aside(std::string why) {
    LogGuess guess;
    guess.format = LogFormat::kColumns;
    guess.part = LogGuess::Part::kNone;
    guess.why = guess.aside = std::move(why);
    return guess;
  }

  // Whether the name of the file, or of the sensor, says so.
  bool named(std::string_view part) const { return name_.find(part) != std::string::npos; }

  bool named_gyroscopes() const { return named("gyr") || named("angular") || named("rotation"); }

  // Columns that are merely x, y and z: by the name of the file, else by their size.
  bool is_of_forces(const ColumnTriad& t) const {
    if (named_gyroscopes()) return false;
    return named("acc") || named("grav") || is_gravity(usual_magnitude(table_, t));
  }

  // Why such columns are of neither triad of an IMU: a magnitude other than gravity does not prove gyroscopes.
  std::string why_no_body(const ColumnTriad& t) const {
    if (is_earth_centred(t)) return std::string("places as ") + std::string(kEarthCentred);
    if (named("mag") || named("compass")) return "of a magnetometer, as its name says";
    if (named_gyroscopes() || is_of_forces(t)) return {};
    return "columns x, y, z of neither gyroscopes nor accelerometers, by their values and the name of the file";
  }

  // The part of the specific force that accelerations are. The quietest sensors have ten times as much noise as
  // kSmooth.
  Part part_of_force(const ColumnTriad& t) const {
    constexpr double kSmooth = 1e-5;  // of gravity
    if (!holds_gravity(table_, t)) return Part::kLinear;
    return named("grav") || magnitude_scatter(table_, t) < kSmooth ? Part::kGravity : Part::kAccel;
  }

  // Why accelerations are not the specific force that a sensor measured, if another file has that.
  std::string why_no_force(Part part, const ColumnTriad& t) const {
    if (named("uncal")) return "uncalibrated, as its name says";
    if (part == Part::kGravity) return "gravity as a fusion has it, without the noise of a sensor";
    if (part == Part::kAccel) return {};
    return fmt::format("accelerations without gravity: they are mostly {:.2g}", usual_magnitude(table_, t));
  }

  double largest(std::size_t column) const {
    double most = 0;
    for (const double v : table_.columns[column].values) most = std::isfinite(v) ? std::max(most, std::abs(v)) : most;
    return most;
  }

  // Whether a column of accuracies was never set: no fix has an accuracy of zero, and the log has places.
  bool is_unset(std::size_t column) const {
    const auto& values = table_.columns[column].values;
    return std::none_of(values.begin(), values.end(), [](double v) { return v > 0; });
  }

  // Degrees if a receiver's angles go beyond them, in u-blox' integers.
  std::string angle_unit(std::size_t column, double most, std::string_view integers) const {
    return largest(column) > most ? std::string(integers) : "deg";
  }

  // The same of latitude and longitude, which may be radians, or degrees and minutes as of NMEA. What would be within
  // three degrees of latitude and longitude zero is radians: nobody lives there.
  std::string place_unit() const {
    constexpr double kTurn = 360;
    const std::size_t latitude = *one("latitude"), longitude = *one("longitude");
    const bool named = has_unit(latitude, dimension::kAngle);
    if (!named && largest(latitude) <= std::numbers::pi / 2 && largest(longitude) <= std::numbers::pi) return "rad";
    const bool whole = table_.columns[latitude].is_whole();
    if (!named && whole && table_.columns[latitude].has("position") && largest(latitude) > kTurn) {
      return std::string(kSemicircle);  // as FIT names them
    }
    if (!named && !whole && has_minutes(latitude) && has_minutes(longitude) && largest(latitude) > kRightAngle) {
      return std::string(kDegreesMinutes);
    }
    return angle_unit(latitude, kTurn, "1e-7 deg");
  }

  // Whether the last two digits before the point of all values are minutes of arc.
  bool has_minutes(std::size_t column) const {
    constexpr double kHundred = 100, kMinutes = 60, kMost = 18000;
    const auto& values = table_.columns[column].values;
    return std::all_of(values.begin(), values.end(), [](double v) {
      return !std::isfinite(v) || (std::abs(v) <= kMost && std::fmod(std::abs(v), kHundred) < kMinutes);
    });
  }

  // Whether a height belongs to the place: a barometer's changes in rows in which the place does not.
  bool is_of_place(std::size_t height) const {
    constexpr double kOften = 1.5;
    const double place = std::max(changing(table_, table_.columns[*one("latitude")]),
                                  changing(table_, table_.columns[*one("longitude")]));
    return changing(table_, table_.columns[height]) < kOften * place || place == 0;
  }

  // Of several heights that which changes with the place; of these that above the ellipsoid, as the other is above the
  // sea; else that named as the receiver's.
  std::optional<std::size_t> height() const {
    std::optional<std::size_t> best;
    int most = -1;
    for (std::size_t c = 0; c < meanings_.size(); ++c) {
      const std::string& key = meanings_[c].key;
      if (key != "height" && key != "sea height") continue;
      const SampledColumn& column = table_.columns[c];
      const bool of_receiver = column.has_any({"gps", "gnss", "location"});
      const bool of_ellipsoid = is_ellipsoidal(column) || column.has_any({"wgs84", "wgs"});
      const int rank =
          (is_of_place(c) ? 8 : 0) + (of_ellipsoid ? 4 : 0) + (of_receiver ? 2 : 0) + (key == "height" ? 1 : 0);
      if (rank > most) best = c;
      most = std::max(rank, most);
    }
    return best;
  }

  // Names the heights that are not the receiver's.
  void doubt_other_heights() {
    for (std::size_t c = 0; c < meanings_.size(); ++c) {
      const bool barometric = table_.columns[c].has_any({"baro", "barometer", "barometric"}) &&
                              table_.columns[c].has_any({"height", "alt", "altitude"});
      const bool height = meanings_[c].key == "height" || meanings_[c].key == "sea height";
      if (barometric || (height && !is_of_place(c) && this->height() != c)) {
        doubts_.push_back(
            fmt::format("{}: a barometer's height, it seems, and left aside; `barometer:` takes it from a "
                        "file of its own",
                        table_.name_of(c)));
      }
    }
  }

  // The column of the geoid, if the height is above the sea.
  void add_geoid(std::size_t height) {
    if (meanings_[height].key != "sea height") return;
    if (const auto geoid = one("geoid")) {
      map_.uses["height"].geoid = table_.name_of(*geoid);
    } else {
      doubts_.emplace_back(
          "height: above the sea, and taken as above the ellipsoid: add the geoid's height where that "
          "matters, up to 100 m");
    }
  }

  std::optional<LogGuess> receiver(const Pace& pace) {
    const auto height = this->height();
    const bool timed = height && find_time(pace, one("latitude"));
    if (!timed && has_body()) return std::nullopt;
    if (!height) lacks("height", "latitude and longitude");
    if (!timed) lacks("time", "a receiver");
    if (has_body()) prefer_held_stamp();
    const std::string angle = place_unit();
    const bool integers = angle == "1e-7 deg" && !has_unit(*one("latitude"), dimension::kAngle);
    const bool millimetres = (integers && table_.columns[*height].is_whole()) || in_millimetres(*height);
    const std::string length = millimetres ? "mm" : "m", velocity = millimetres ? "mm/s" : "m/s";
    if (millimetres) {
      doubts_.emplace_back(fmt::format("units: whole numbers as u-blox writes them are taken: {}mm, mm/s",
                                       integers ? "1e-7 deg, " : ""));
    }
    use("latitude", {*one("latitude")}, dimension::kAngle, angle).hemisphere = hemisphere('N', 'S');
    ColumnUse& longitude = use("longitude", {*one("longitude")}, dimension::kAngle, angle);
    longitude.hemisphere = hemisphere('E', 'W');
    if (const std::string& along = table_.columns[*one("longitude")].along; !along.empty()) longitude.axes = {along};
    use("height", {*height}, dimension::kLength, length);
    add_geoid(*height);
    if (const auto sigma = group("sigma", "neu")) {
      use("sigma", *sigma, dimension::kLength, length).axes = {"north", "east", "up"};
    } else if (const auto down = group("sigma", "ned")) {
      use("sigma", *down, dimension::kLength, length);
    } else if (const auto across = one("horizontal_accuracy"); across && is_unset(*across)) {
      doubts_.push_back(
          fmt::format("{}: never above zero, and of no row then, so that it is not used", table_.name_of(*across)));
    } else if (across) {
      const std::size_t vertical = one("vertical_accuracy").value_or(*across);
      use("horizontal_accuracy", {*across}, dimension::kLength, table_.columns[*across].is_whole() ? length : "m");
      use("vertical_accuracy", {vertical}, dimension::kLength, table_.columns[vertical].is_whole() ? length : "m");
      doubts_.emplace_back("accuracies: taken for radii of 68 %, as phones and u-blox state them");
      if (vertical == *across) doubts_.emplace_back("heights: that of places is taken for theirs, as the log has none");
    }
    receiver_velocity(velocity, integers && millimetres);
    doubt_other_heights();
    if (const auto fix = one("fix")) {
      const SampledColumn& c = table_.columns[*fix];
      constexpr double kMostKinds = 9;
      if (c.words.back() == "type") {
        fix_type(*fix);
      } else if (c.has("quality") && c.is_whole() && largest(*fix) <= kMostKinds) {
        use_quality(*fix, "nmea");  // 0 is none
      }
    }
    find_quality();
    return taken(LogKind::kGnss, LogGuess::Part::kWhole, "columns named as those of a receiver");
  }

  // A column of qualities by their numbers, unless it leaves out every row.
  void use_quality(std::size_t column, const std::string& of) {
    const auto quality = of == "nmea" ? log_formats::quality_of_nmea : log_formats::quality_of_rtklib;
    const auto& values = table_.columns[column].values;
    if (std::none_of(values.begin(), values.end(), [&](double v) { return quality(v).has_value(); })) {
      doubts_.push_back(
          fmt::format("{}: says of every row that it has no fix, so that it is not used", table_.name_of(column)));
      return;
    }
    use("quality", {column}, dimension::kRatio, "").of = of;
  }

  // The receiver's own time, where rows of the IMU repeat the last fix: a time that changes as the place does, and
  // runs as the time of the rows.
  void prefer_held_stamp() {
    const std::array<std::size_t, 2> place{*one("latitude"), *one("longitude")};
    const auto changes = [&](std::size_t column, std::size_t row) {
      const auto& texts = table_.columns[column].texts;
      return row > 0 && !table_.begins(row) && texts[row] != texts[row - 1];
    };
    const auto is_new = [&](std::size_t row) { return changes(place[0], row) || changes(place[1], row); };
    const ColumnTable fixes = table_.rows_where(is_new);
    if (fixes.rows < 3 || 2 * fixes.rows > table_.rows) return;
    std::vector<ColumnMeaning> held = meanings_;
    for (std::size_t c = 0; c < held.size(); ++c) {
      if (held[c].key != "time") continue;
      std::size_t both = 0, either = 0;
      for (std::size_t row = 0; row < table_.rows; ++row) {
        both += is_new(row) && changes(c, row) ? 1 : 0;
        either += is_new(row) || changes(c, row) ? 1 : 0;
      }
      constexpr double kAlike = 0.8;
      if (c == time_column_ || static_cast<double>(both) < kAlike * static_cast<double>(either)) held[c].key.clear();
    }
    if (!column_of(held, "time")) return;
    auto found = piste::find_time(file_, fixes, held, kGnssPace, "");
    if (!found || found->time.of == TimeScale::kBoot) return;
    map_.time = std::move(found->time);
    boot_.reset();
  }

  // The quality of fixes by RTKLIB's Q, or by a column of words such as FIX and FLOAT.
  void find_quality() {
    constexpr double kMostKinds = 7;
    if (map_.find("quality") != nullptr) return;
    if (const auto q = one("q"); q && table_.columns[*q].is_whole() && largest(*q) <= kMostKinds) {
      use_quality(*q, "rtklib");
      return;
    }
    for (std::size_t c = 0; c < table_.columns.size(); ++c) {
      const auto& texts = table_.columns[c].texts;
      bool words = !texts.empty(), several = false;
      for (const std::string_view text : texts) {
        const auto quality = log_formats::quality_of_word(text);
        words = words && quality;
        several = several || quality == FixQuality::kFloat || quality == FixQuality::kSbas;
        if (!words) break;
      }
      if (!words || !several) continue;
      use("quality", {c}, dimension::kRatio, "");
      return;
    }
  }

  // Whether heights, accuracies and velocities are whole numbers, too large for metres: as of UBX-NAV-PVT where a
  // program has divided the angles alone.
  bool in_millimetres(std::size_t height) const {
    constexpr double kHighest = 1e4;  // m
    const auto whole = [&](std::optional<std::size_t> c) { return !c || table_.columns[*c].is_whole(); };
    const auto velocity = group("velocity", "ned");
    return largest(height) > kHighest && !has_unit(height, dimension::kLength) && whole(height) &&
           whole(one("horizontal_accuracy")) && whole(one("vertical_accuracy")) && whole(one("speed")) &&
           (!velocity || std::all_of(velocity->begin(), velocity->end(), [&](std::size_t c) { return whole(c); }));
  }

  // The column of these letters; empty if there is none.
  std::string hemisphere(char positive, char negative) const {
    for (std::size_t c = 0; c < table_.columns.size(); ++c) {
      const std::string_view text = table_.columns[c].first();
      if (text.size() != 1) continue;
      const char letter = static_cast<char>(std::toupper(static_cast<unsigned char>(text[0])));
      if (letter == positive || letter == negative) return table_.name_of(c);
    }
    return {};
  }

  // u-blox counts 2D, 3D, with dead reckoning from 2, and the time alone as 5; MAVLink and PX4 count 3D, DGPS, float
  // and fixed RTK, static, PPP from 3. That of u-blox goes no further than 5.
  void fix_type(std::size_t column) {
    constexpr double kTimeAlone = 5;
    const double most = largest(column);
    if (const auto& values = table_.columns[column].values;
        std::none_of(values.begin(), values.end(), [](double v) { return v >= 2; })) {
      doubts_.push_back(fmt::format("{}: leaves out every row as u-blox counts, 2D from 2, so that it is not used",
                                    table_.name_of(column)));
      return;
    }
    std::vector<double>& valid = use("fix", {column}, dimension::kRatio, "").valid;
    if (most > kTimeAlone) {
      valid = {3, 4, 5, 6, 7, 8};
      doubts_.emplace_back("fix: taken as MAVLink and PX4 write it: 3 is 3D, 4 DGPS, 5 and 6 RTK, 7 static, 8 PPP");
      return;
    }
    valid = {2, 3, 4};
    doubts_.emplace_back("fix: taken as u-blox writes it: 2 is 2D, 3 is 3D, 4 with dead reckoning");
    if (most == kTimeAlone)
      doubts_.back() += ", 5 the time alone; as MAVLink writes it, 5 is RTK: then `valid: [3, 4, 5, 6]`";
  }

  // Whether the directions from place to place are those of the course in radians, and not in degrees.
  bool is_course_in_radians() const {
    constexpr double kTurn = 6.3, kFar = 10, kRadius = 6.4e6;  // rad, m
    constexpr std::size_t kRows = 2000, kFewest = 8;
    const std::size_t course = *one("course");
    if (largest(course) > kTurn) return false;
    const double unit = unit_factor(
        map_.find("latitude")->unit.empty() ? table_.columns[*one("latitude")].cell.unit : map_.find("latitude")->unit,
        dimension::kAngle);
    const auto& north = table_.columns[*one("latitude")].values;
    const auto& east = table_.columns[*one("longitude")].values;
    const auto& turned = table_.columns[course].values;
    double as_radians = 0, as_degrees = 0;
    std::size_t legs = 0;
    for (std::size_t from = 0, to = 1; to < table_.rows; ++to) {
      if (table_.begins(to) || to - from > kRows || !std::isfinite(north[from])) from = to;
      if (!std::isfinite(north[to])) continue;
      const double dn = kRadius * unit * (north[to] - north[from]),
                   de = kRadius * unit * (east[to] - east[from]) * std::cos(unit * north[to]);
      if (!(std::hypot(dn, de) > kFar)) continue;
      const double direction = std::atan2(de, dn), stated = turned[(from + to) / 2];
      from = to;
      if (!std::isfinite(stated)) continue;
      ++legs;
      as_radians += std::cos(stated - direction);
      as_degrees += std::cos(stated * std::numbers::pi / 180 - direction);
    }
    return legs >= kFewest && as_radians > as_degrees && 2 * as_radians > static_cast<double>(legs);
  }

  void receiver_velocity(const std::string& unit, bool integers) {
    auto velocity = group("velocity", "ned");
    const bool up = !velocity && group("velocity", "neu");
    if (up) velocity = group("velocity", "neu");
    if (velocity) {
      ColumnUse& entry = use("velocity", *velocity, dimension::kVelocity, unit);
      if (up) entry.axes = {"north", "east", "up"};
      const auto spread = group("sigma_velocity", up ? "neu" : "ned");
      if (spread) {
        ColumnUse& sigma = use("sigma_velocity", *spread, dimension::kVelocity, unit);
        if (up) sigma.axes = {"north", "east", "up"};
      }
    } else if (one("speed") && one("course")) {
      constexpr double kTurn = 360;
      use("speed", {*one("speed")}, dimension::kVelocity, unit);
      const bool radians = !has_unit(*one("course"), dimension::kAngle) && is_course_in_radians();
      if (radians) doubts_.emplace_back("course: in radians, as the places have it");
      use("course", {*one("course")}, dimension::kAngle,
          radians ? "rad" : angle_unit(*one("course"), kTurn, "1e-5 deg"));
      if (const auto turn = one("course_accuracy"); turn && is_of_course(*turn)) {
        use("course_accuracy", {*turn}, dimension::kAngle, integers ? "1e-5 deg" : "deg");
      }
    } else {
      return;
    }
    const auto speed_accuracy = one("speed_accuracy");
    if (speed_accuracy && map_.find("sigma_velocity") == nullptr) {
      use("speed_accuracy", {*speed_accuracy}, dimension::kVelocity, unit);
    }
  }

  // Whether an accuracy is that of the course. In a table that also has a course, one of the heading is of the compass.
  bool is_of_course(std::size_t accuracy) const {
    const auto heading = [&](std::size_t c) { return table_.columns[c].has_any({"head", "heading"}); };
    return !heading(accuracy) || heading(*one("course"));
  }

  std::optional<LogGuess> attitude() {
    if (!find_time(kAttitudePace)) return std::nullopt;
    boot_.reset();
    const std::size_t heading = one("heading") ? *one("heading") : *one("course");
    constexpr double kHalfTurn = 3.2;  // rad
    const bool radians =
        largest(*one("roll")) < kHalfTurn && largest(*one("pitch")) < kHalfTurn && largest(heading) < 2 * kHalfTurn;
    use("angles", {*one("roll"), *one("pitch"), heading}, dimension::kAngle, radians ? "rad" : "deg");
    return taken(LogKind::kAttitude, LogGuess::Part::kWhole, "columns roll, pitch and heading");
  }

  std::string file_, name_;
  const ColumnTable& table_;
  Part part_;
  std::vector<ColumnMeaning> meanings_;
  ColumnMap map_;
  std::optional<ColumnTime> boot_;
  std::optional<ColumnTriad> added_;  // gravity, to accelerations without it
  std::size_t time_column_ = 0;
  bool guessed_rates_ = false;
  std::vector<std::string> doubts_;
};

// The logs of several sensors in one file: the first, and the others as LogGuess::beside.
class SeveralLogs {
 public:
  explicit SeveralLogs(std::string file) : file_(std::move(file)) {}

  // Guesses the log of one sensor, or of several that are numbered, from the rows that `chosen` selects.
  void add(const ColumnTable& rows, const std::vector<ColumnRows>& chosen) {
    if (const auto kinds = row_kinds(rows); kinds && kinds->numbered) {
      const SampledColumn& column = rows.columns[kinds->column];
      for (const std::string& kind : kinds->kinds) {
        std::vector<ColumnRows> both = chosen;
        both.push_back({rows.name_of(kinds->column), kind});
        add_one(rows.rows_where([&](std::size_t row) { return column.texts[row] == kind; }), both);
      }
      return;
    }
    add_one(rows, chosen);
  }

  // Whether the logs are of one kind and part: then the column does not separate sensors.
  bool are_alike() const {
    return logs_.size() > 1 && std::all_of(logs_.begin(), logs_.end(), [&](const LogGuess& log) {
             return log.kind == logs_[0].kind && log.part == logs_[0].part;
           });
  }

  std::optional<LogGuess> take() {
    if (logs_.empty()) return std::nullopt;
    LogGuess first = std::move(logs_.front());
    first.beside.assign(std::make_move_iterator(logs_.begin() + 1), std::make_move_iterator(logs_.end()));
    return first;
  }

 private:
  void add_one(const ColumnTable& rows, const std::vector<ColumnRows>& chosen) {
    auto guess = guess_of(rows, chosen[0].is);
    if (!guess || guess->part == LogGuess::Part::kNone) return;
    for (const ColumnRows& c : chosen) guess->why += fmt::format(", in the rows with {} in column {}", c.is, c.name);
    guess->lost.clear();  // the other columns are of the other rows
    std::vector<LogGuess> others = std::move(guess->beside);
    guess->beside.clear();
    logs_.push_back(std::move(*guess));
    logs_.insert(logs_.end(), std::make_move_iterator(others.begin()), std::make_move_iterator(others.end()));
    for (std::size_t i = logs_.size() - 1 - others.size(); i < logs_.size(); ++i) logs_[i].columns->rows = chosen;
  }

  // Nothing for rows without a time, for example: other rows may have one.
  std::optional<LogGuess> guess_of(const ColumnTable& rows, const std::string& name) const {
    try {
      return Guesser(file_, name, rows).guess();
    } catch (const DataError&) {
      return std::nullopt;
    }
  }

  std::string file_;
  std::vector<LogGuess> logs_;
};

std::optional<LogGuess> guess_kinds(const std::string& file, ColumnTable table) {
  SeveralLogs logs(file);
  const auto kinds = row_kinds(table);
  if (!kinds) return std::nullopt;
  const SampledColumn& column = table.columns[kinds->column];
  // If a column must be numbered, so must the others, as only its rows are read.
  table.by_number = column_number(table.name_of(kinds->column)).has_value();
  for (const std::string& kind : kinds->kinds) {
    const ColumnRows chosen{table.name_of(kinds->column), kind};
    logs.add(table.rows_where([&](std::size_t row) { return column.texts[row] == kind; }), {chosen});
  }
  if (!kinds->numbered && logs.are_alike()) return std::nullopt;
  return logs.take();
}

std::optional<LogGuess> guess_tagged(const std::string& file, std::string_view content) {
  SeveralLogs logs(file);
  for (const TaggedRows& rows : tagged_rows(content)) logs.add(rows.table, {{"1", rows.tag}});
  auto first = logs.take();
  if (first) first->clock = tagged_clock(content);
  return first;
}

}  // namespace

std::string known_columns(std::string_view content) {
  constexpr std::size_t kMost = 20;  // columns of either kind
  const auto table = sample_columns(content);
  if (!table || !table->header) return {};
  std::vector<std::string> known, others;
  for (const SampledColumn& c : table->columns) {
    const ColumnMeaning meaning = meaning_of(c);
    const std::string axis = meaning.axis != 0 ? fmt::format(" {}", meaning.axis) : "";
    if (meaning.key.empty() && others.size() < kMost) others.push_back(fmt::format("`{}`", c.cell.whole));
    if (!meaning.key.empty() && known.size() < kMost)
      known.push_back(fmt::format("`{}` ({}{})", c.cell.whole, meaning.key, axis));
  }
  const auto list = [](const std::vector<std::string>& names) {
    return names.empty() ? std::string("none") : fmt::format("{}", fmt::join(names, ", "));
  };
  return fmt::format("Of its columns these are known: {}; and not: {}", list(known), list(others));
}

std::optional<LogGuess> guess_columns(const std::string& file, std::string_view content) {
  if (auto guess = guess_tagged(file, content)) return guess;
  auto table = sample_columns(content);
  if (!table) return std::nullopt;
  declare_columns(content, *table);
  if (auto guess = guess_kinds(file, *table)) return guess;
  return Guesser(file, std::filesystem::path(file).stem().string(), *table).guess();
}

}  // namespace piste
