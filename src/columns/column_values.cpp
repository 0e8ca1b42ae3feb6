#include "column_values.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "piste/math/earth.h"
#include "piste/math/statistics.h"
#include "piste/math/units.h"

namespace piste {
namespace {

constexpr double kNearGravity = 1.2;  // factor
constexpr double kLargest = 1e300;

struct NamedValue {
  std::string_view name;
  double value;
};
constexpr std::array<NamedValue, 4> kGravities{
    {{"m/s^2", kStandardGravity}, {"g", 1}, {"mg", 1e3}, {"cm/s^2", 1e2 * kStandardGravity}}};

bool is_near(double a, double b) { return std::abs(std::log(a / b)) < std::log(kNearGravity); }

Vector3d row_of(const ColumnTable& table, const ColumnTriad& triad, std::size_t row) {
  return {table.columns[triad[0]].values[row], table.columns[triad[1]].values[row],
          table.columns[triad[2]].values[row]};
}

double median_of(const std::vector<double>& values) {
  std::vector<double> finite;
  std::copy_if(values.begin(), values.end(), std::back_inserter(finite), [](double v) { return std::isfinite(v); });
  return finite.empty() ? std::nan("") : median(std::move(finite));
}

// The white noise of a row in the quietest tenth of the log, of the quietest of three columns: by the differences of
// means over `rows` rows, which vibration that is faster does not reach.
double quiet_noise(const ColumnTable& table, const ColumnTriad& triad, std::size_t rows) {
  constexpr std::size_t kPiece = 40, kTenth = 10;
  std::vector<Vector3d> means;
  for (std::size_t first = 0; first + rows <= table.rows; first += rows) {
    Vector3d sum = Vector3d::Zero();
    for (std::size_t i = first; i < first + rows; ++i) sum += row_of(table, triad, i);
    means.emplace_back(sum / static_cast<double>(rows));
  }
  std::vector<double> noises;
  for (std::size_t first = 0; first + kPiece < means.size(); first += kPiece) {
    Vector3d squares = Vector3d::Zero();
    for (std::size_t i = first; i < first + kPiece; ++i) squares += (means[i + 1] - means[i]).cwiseAbs2();
    const double variance = static_cast<double>(rows) * squares.minCoeff() / (2 * kPiece);
    if (std::isfinite(variance)) noises.push_back(std::sqrt(variance));
  }
  if (noises.empty()) return std::numeric_limits<double>::infinity();
  std::sort(noises.begin(), noises.end());
  return noises[noises.size() / kTenth];
}

// The same by that length of the means which shows the least: motors shake some lengths, and motion others.
double quiet_noise(const ColumnTable& table, const ColumnTriad& triad) {
  double least = std::numeric_limits<double>::infinity();
  for (const std::size_t rows : {1, 5, 10, 20}) least = std::min(least, quiet_noise(table, triad, rows));
  return std::isfinite(least) ? least : 0;
}

// Four columns that are a unit quaternion.
bool is_quaternion(const ColumnTable& table, std::size_t first) {
  if (first + 4 > table.columns.size()) return false;
  std::size_t unit = 0;
  for (std::size_t row = 0; row < table.rows; ++row) {
    double squares = 0;
    for (std::size_t c = first; c < first + 4; ++c)
      squares += table.columns[c].values[row] * table.columns[c].values[row];
    if (std::abs(squares - 1) < 5e-3) ++unit;
  }
  return unit > table.rows * 9 / 10;
}

// How far from zero three columns stand, over how much they vary. Gyroscopes vary about zero.
double offset_over_scatter(const ColumnTable& table, const ColumnTriad& triad) {
  Vector3d mean = Vector3d::Zero(), squares = Vector3d::Zero();
  double rows = 0;
  for (std::size_t i = 0; i < table.rows; ++i) {
    const Vector3d now = row_of(table, triad, i);
    if (!now.allFinite()) continue;
    mean += now;
    squares += now.cwiseAbs2();
    ++rows;
  }
  if (rows == 0) return kLargest;
  mean /= rows;
  const double scatter = (squares / rows - mean.cwiseAbs2()).sum();
  return scatter > 0 ? mean.norm() / std::sqrt(scatter) : kLargest;
}

// How far the length of three columns goes from its median, in the livelier tenth of the rows.
double lively_scatter(const ColumnTable& table, const ColumnTriad& triad) {
  constexpr double kLively = 0.9;
  const double magnitude = usual_magnitude(table, triad);
  std::vector<double> off;
  for (std::size_t i = 0; i < table.rows; ++i) {
    const double now = std::abs(row_of(table, triad, i).norm() / magnitude - 1);
    if (std::isfinite(now)) off.push_back(now);
  }
  if (off.empty()) return 0;
  const auto at = off.begin() + static_cast<std::ptrdiff_t>(kLively * static_cast<double>(off.size() - 1));
  std::nth_element(off.begin(), at, off.end());
  return *at;
}

// The first column of the specific force, among those of triads as large as gravity. Of all triads only forces have a
// magnitude of 9.8, and it scatters little. A magnetometer's field of unit length is as steady as forces in g at rest,
// and steadier in motion.
std::optional<std::size_t> most_likely_forces(const ColumnTable& table, std::vector<std::size_t> candidates) {
  constexpr double kSteady = 0.2, kMotion = 0.05;  // of the length
  const auto triad = [](std::size_t c) { return ColumnTriad{c, c + 1, c + 2}; };
  const auto in_metres = [&](std::size_t c) { return is_near(usual_magnitude(table, triad(c)), kStandardGravity); };
  if (std::any_of(candidates.begin(), candidates.end(), in_metres))
    std::erase_if(candidates, [&](std::size_t c) { return !in_metres(c); });
  const auto by = [&](const auto& measure) {
    return [&](std::size_t a, std::size_t b) { return measure(table, triad(a)) < measure(table, triad(b)); };
  };
  const auto steady = [&](std::size_t c) { return magnitude_scatter(table, triad(c)) < kSteady; };
  if (std::count_if(candidates.begin(), candidates.end(), steady) > 1) {
    std::erase_if(candidates, [&](std::size_t c) { return !steady(c); });
    const auto liveliest = std::max_element(candidates.begin(), candidates.end(), by(lively_scatter));
    return lively_scatter(table, triad(*liveliest)) > kMotion ? *liveliest : candidates.front();
  }
  const auto best = std::min_element(candidates.begin(), candidates.end(), by(magnitude_scatter));
  return best == candidates.end() ? std::nullopt : std::optional(*best);
}

}  // namespace

double usual_magnitude(const ColumnTable& table, const ColumnTriad& triad) {
  std::vector<double> norms(table.rows);
  for (std::size_t i = 0; i < table.rows; ++i) norms[i] = row_of(table, triad, i).norm();
  return median_of(norms);
}

double magnitude_scatter(const ColumnTable& table, const ColumnTriad& triad) {
  const double magnitude = usual_magnitude(table, triad);
  std::vector<double> off(table.rows);
  for (std::size_t i = 0; i < table.rows; ++i) off[i] = std::abs(row_of(table, triad, i).norm() / magnitude - 1);
  return median_of(off);
}

bool is_gravity(double magnitude) {
  return std::any_of(kGravities.begin(), kGravities.end(), [&](const auto& g) { return is_near(magnitude, g.value); });
}

bool holds_gravity(const ColumnTable& table, const ColumnTriad& triad) {
  constexpr std::size_t kPiece = 40, kTenth = 10;
  const double usual = usual_magnitude(table, triad);
  if (!is_gravity(usual)) return false;
  struct Piece {
    double variance, mean;
  };
  std::vector<Piece> pieces;
  for (std::size_t first = 0; first + kPiece <= table.rows; first += kPiece) {
    Vector3d sum = Vector3d::Zero();
    double squares = 0;
    for (std::size_t i = first; i < first + kPiece; ++i) {
      sum += row_of(table, triad, i);
      squares += row_of(table, triad, i).squaredNorm();
    }
    const Vector3d mean = sum / kPiece;
    if (mean.allFinite()) pieces.push_back({squares / kPiece - mean.squaredNorm(), mean.norm()});
  }
  if (pieces.empty()) return true;
  std::sort(pieces.begin(), pieces.end(), [](const Piece& a, const Piece& b) { return a.variance < b.variance; });
  std::vector<double> quiet;
  for (std::size_t i = 0; i <= pieces.size() / kTenth && i < pieces.size(); ++i) quiet.push_back(pieces[i].mean);
  return 2 * median(std::move(quiet)) > usual;
}

UnitGuess gravity_unit(double magnitude) {
  for (const NamedValue& g : kGravities) {
    if (is_near(magnitude, g.value)) return {std::string(g.name)};
  }
  constexpr double kSmallestCounts = 200;
  if (!(magnitude > kSmallestCounts)) {
    return {"m/s^2",
            fmt::format("the magnitude of the specific force is mostly {:.3g}, that of gravity in no unit that "
                        "is known: m/s^2 is taken",
                        magnitude)};
  }
  return {
      fmt::format("{:.5g} g", 1 / magnitude),
      fmt::format("counts, it seems, {:.0f} for one g as gravity has it: give the scale of the data sheet", magnitude),
      true};
}

// Of 16 bits: InvenSense and Bosch at 250, 500, 1000 and 2000 deg/s, ST at 245, 500, 1000 and 2000 deg/s; and whole
// degrees, as Betaflight logs them.
std::span<const double> count_units() {
  static constexpr std::array kUnits{1 / 131.0, 1 / 65.5, 1 / 32.8, 1 / 16.4, 0.00875, 0.0175, 0.035, 0.07, 1.0};
  return kUnits;
}

UnitGuess turn_counts() {
  return {fmt::format("{:.6g} deg/s", count_units()[0]),
          "counts, it seems, as of the accelerometers: give the scale of the data sheet", true};
}

UnitGuess turn_unit(const ColumnTable& table, const ColumnTriad& triad) {
  constexpr double kFastest = 35;                                // rad/s, twice around in a third of a second
  constexpr double kMilli = 5000;                                // deg/s that no sensor measures
  constexpr double kNoisyRadians = 0.03, kQuietDegrees = 0.012;  // MEMS have 0.02 to 1 deg/s of noise a sample
  double largest = 0;
  for (std::size_t i = 0; i < table.rows; ++i) {
    const double now = row_of(table, triad, i).cwiseAbs().maxCoeff();
    if (std::isfinite(now)) largest = std::max(largest, now);
  }
  const double noise = quiet_noise(table, triad);
  if (largest > kMilli) return {"mdeg/s", "rates up to " + fmt::format("{:.0f}: mdeg/s are taken", largest)};
  if (largest > kFastest) return {"deg/s"};
  if (noise > kNoisyRadians) {
    return {"deg/s",
            fmt::format("deg/s is taken, as the noise of {:.2g} is that of few sensors in rad/s: check it", noise)};
  }
  if (noise > 0 && noise < kQuietDegrees) return {"rad/s"};
  return {"rad/s", fmt::format("the values do not determine whether rates are in rad/s or deg/s (noise {:.2g}, largest "
                               "{:.3g}): rad/s is taken",
                               noise, largest)};
}

Steps steps_of(const ColumnTable& table, const std::vector<double>& values) {
  Steps steps;
  std::vector<double> up;
  double all = 0, risen = 0, fallen = 0;
  for (std::size_t i = 1; i < values.size(); ++i) {
    steps.whole = steps.whole && values[i] == std::floor(values[i]);
    if (table.begins(i)) continue;
    const double step = values[i] - values[i - 1];
    if (!std::isfinite(step)) return {};
    ++all;
    if (step > 0) up.push_back(step);
    if (step < 0) ++steps.falls;
    (step > 0 ? risen : fallen) += std::abs(step);
  }
  if (all == 0) return steps;
  steps.first = values[0];
  steps.increasing = static_cast<double>(up.size()) / all;
  steps.backwards = static_cast<double>(steps.falls) / all;
  steps.lost = risen > 0 ? fallen / risen : 0;
  steps.mean = (risen - fallen) / all;
  steps.median = up.empty() ? 0 : median(std::move(up));
  return steps;
}

double changing(const ColumnTable& table, const SampledColumn& column) {
  double all = 0, changed = 0;
  for (std::size_t i = 1; i < column.texts.size(); ++i) {
    if (table.begins(i)) continue;
    ++all;
    changed += column.texts[i] != column.texts[i - 1] ? 1 : 0;
  }
  return all > 0 ? changed / all : 0;
}

bool is_time_of_day(const ColumnTable& table, const std::vector<double>& values) {
  constexpr double kHundred = 100, kMinute = 60, kDay = 240000, kLeap = kHundred - kMinute;
  bool leapt = false;
  for (std::size_t i = 0; i < values.size(); ++i) {
    const double v = values[i], minutes = std::floor(v / kHundred);
    if (!(v >= 0 && v < kDay && std::fmod(v, kHundred) < kMinute && std::fmod(minutes, kHundred) < kMinute))
      return false;
    if (i == 0 || table.begins(i) || minutes == std::floor(values[i - 1] / kHundred)) continue;
    const double step = v - values[i - 1];
    leapt = leapt || (step >= kLeap && std::fmod(values[i - 1], kHundred) > kMinute / 2);
  }
  return leapt;
}

std::string time_unit(const Steps& steps, const Pace& pace) {
  constexpr std::array<NamedValue, 4> kUnits{{{"s", 1}, {"ms", 1e-3}, {"us", 1e-6}, {"ns", 1e-9}}};
  constexpr double kSince = 9e8, kUntil = 4e9;  // s since 1970 or 1980 of the times in which logs are written
  for (const NamedValue& unit : kUnits) {
    const double first = steps.first * unit.value, step = steps.median * unit.value;
    const bool possible = step > pace.fastest && step < pace.slowest;
    if (first > kSince && first < kUntil && possible) return std::string(unit.name);
  }
  // Slow loggers write 0.5, 1.0, 1.5 s. Fractions of a millisecond are those of loggers that count faster units.
  constexpr double kSlowest = 2;  // s
  if (!steps.whole && steps.median > 0.1 && steps.median <= kSlowest) return "s";
  const auto off = [&](const NamedValue& unit) { return std::abs(std::log(steps.median * unit.value / pace.usual)); };
  return std::string(std::min_element(kUnits.begin(), kUnits.end(), [&](const auto& a, const auto& b) {
                       return off(a) < off(b);
                     })->name);
}

std::optional<ValueTriads> find_triads(const ColumnTable& table, std::size_t time) {
  const std::size_t count = table.columns.size();
  std::vector<bool> taken(count, false);
  taken[time] = true;
  for (std::size_t c = 0; c < count; ++c) {
    if (is_quaternion(table, c)) std::fill_n(taken.begin() + static_cast<std::ptrdiff_t>(c), 4, true);
  }
  for (std::size_t c = 0; c < count; ++c) {
    // Such as numbers of sensors, and covariances of zero.
    if (changing(table, table.columns[c]) == 0 && table.columns[c].is_whole()) taken[c] = true;
  }
  const auto free = [&](std::size_t c) { return c + 3 <= count && !taken[c] && !taken[c + 1] && !taken[c + 2]; };
  const auto triad = [](std::size_t c) { return ColumnTriad{c, c + 1, c + 2}; };
  // Of columns side by side the first three are a triad, then the next: at rest two axes of the accelerometers and one
  // of the gyroscopes are as large as gravity too.
  const auto aligned = [&](std::size_t c) {
    std::size_t first = c;
    while (first > 0 && !taken[first - 1]) --first;
    return (c - first) % 3 == 0;
  };
  const auto is_candidate = [&](std::size_t c) { return free(c) && holds_gravity(table, triad(c)); };
  bool any_aligned = false;
  for (std::size_t c = 0; c < count; ++c) any_aligned = any_aligned || (is_candidate(c) && aligned(c));
  std::vector<std::size_t> candidates;
  for (std::size_t c = 0; c < count; ++c) {
    if (is_candidate(c) && (!any_aligned || aligned(c))) candidates.push_back(c);
  }
  const auto accel = most_likely_forces(table, candidates);
  if (!accel) return std::nullopt;
  std::fill_n(taken.begin() + static_cast<std::ptrdiff_t>(*accel), 3, true);
  // The nearest three on either side.
  std::optional<std::size_t> before, behind;
  for (std::size_t c = *accel; c-- > 0 && !before;) before = free(c) ? std::optional(c) : std::nullopt;
  for (std::size_t c = *accel + 3; c < count && !behind; ++c) behind = free(c) ? std::optional(c) : std::nullopt;
  std::optional<std::size_t> gyro;
  double nearest = kLargest;
  for (const auto& c : {before, behind}) {
    if (!c) continue;
    if (const double off = offset_over_scatter(table, triad(*c)); off < nearest) {
      nearest = off;
      gyro = c;
    }
  }
  if (!gyro) return std::nullopt;
  return ValueTriads{triad(*accel), triad(*gyro)};
}

std::optional<ValuePlace> find_place(const ColumnTable& table, std::size_t time) {
  constexpr double kSmoothly = 2e-5, kMostLatitude = 90, kMostLongitude = 180;  // of the value; deg
  const std::size_t count = table.columns.size();
  const auto is_angle = [&](std::size_t c, double most) {
    const SampledColumn& column = table.columns[c];
    if (c == time || column.is_whole() || 2 * changing(table, column) < 1) return false;
    std::vector<double> steps;
    for (std::size_t i = 0; i < column.values.size(); ++i) {
      if (!(std::abs(column.values[i]) <= most)) return false;
      if (i > 0 && !table.begins(i) && column.values[i] != 0)  // as before the first fix
        steps.push_back(std::abs(column.values[i] - column.values[i - 1]) / std::abs(column.values[i]));
    }
    return !steps.empty() && median(std::move(steps)) < kSmoothly;
  };
  for (std::size_t c = 0; c + 2 < count; ++c) {
    if (!is_angle(c, kMostLatitude) || !is_angle(c + 1, kMostLongitude)) continue;
    for (std::size_t h = c + 2; h < count; ++h) {
      if (h != time && changing(table, table.columns[h]) > 0) return ValuePlace{c, c + 1, h};
    }
  }
  return std::nullopt;
}

}  // namespace piste
