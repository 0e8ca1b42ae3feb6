#include "column_repair.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "columns/column_values.h"
#include "io/column_axes.h"
#include "log_factors.h"
#include "piste/math/earth.h"
#include "piste/math/units.h"
#include "velocity_fit.h"

namespace piste {
namespace {

// The direction that the mapping gives a column.
Vector3d direction_of(const ColumnUse& use, std::size_t column, const std::array<AxisNames, 3>& names) {
  Vector3d direction = Vector3d::Unit(static_cast<Eigen::Index>(column));
  for (std::size_t i = 0; i < 3 && !use.axes.empty(); ++i) {
    const auto axis = static_cast<Eigen::Index>(i);
    if (use.axes[column] == names[i][0]) direction = Vector3d::Unit(axis);
    if (use.axes[column] == names[i][1]) direction = -Vector3d::Unit(axis);
  }
  return direction;
}

// Turns the directions of all columns by a signed permutation. Returns whether each direction still has a name.
bool turn(ColumnUse& use, const Matrix3d& by, const std::array<AxisNames, 3>& names) {
  if (by.isIdentity()) return true;
  std::vector<std::string> axes;
  for (std::size_t column = 0; column < use.names.size(); ++column) {
    const Vector3d direction = by * direction_of(use, column, names);
    Eigen::Index axis = 0;
    direction.cwiseAbs().maxCoeff(&axis);
    if (axis == 2 && use.names.size() < 3) return false;
    axes.emplace_back(names[static_cast<std::size_t>(axis)][direction(axis) < 0 ? 1 : 0]);
  }
  use.axes = std::move(axes);
  return true;
}

// Gives a quantity another name and unit.
void rename(ColumnMap& map, const std::string& from, const std::string& to, const std::string& unit) {
  auto node = map.uses.extract(from);
  node.key() = to;
  node.mapped().unit = unit;
  map.uses.insert(std::move(node));
}

// Another unit, after the number of the present one: `0.001 rad/s` becomes `0.001 deg/s`.
std::string with_number_of(const std::string& present, const std::string& unit) {
  const auto end = present.find(' ');
  const bool number = end != std::string::npos && present.find_first_not_of("0123456789.eE+-") >= end;
  return number ? present.substr(0, end + 1) + unit : unit;
}

// The unit of raw counts with which the turns agree with the track; empty if `unit` is no unit of counts, or agrees.
std::string count_unit(const std::string& unit, double turn_ratio) {
  constexpr double kNear = 1.3;  // a factor; ranges differ by two
  const auto candidates = count_units();
  const auto text = [](double u) { return fmt::format("{:.6g} deg/s", u); };
  const auto now = std::find_if(candidates.begin(), candidates.end(), [&](double u) { return text(u) == unit; });
  if (now == candidates.end()) return {};
  const auto off = [&](double u) { return std::abs(std::log(turn_ratio * u / *now)); };
  const auto best =
      std::min_element(candidates.begin(), candidates.end(), [&](double a, double b) { return off(a) < off(b); });
  return off(*best) < std::log(kNear) && off(*best) + 1e-9 < off(*now) ? text(*best) : std::string();
}

// Gives the triads the quantity and the unit that the track requires.
void scale_rates(ColumnMap& map, const LogMatch& match) {
  const LogFactors factors = log_factors(match);
  const bool increments = map.find("dtheta") != nullptr;
  const double as_rates = 1 / match.interval, as_increments = match.interval;
  if (!increments && rather_factor(factors.gyro, as_rates) && rather_factor(factors.accel, as_rates)) {
    map = increments_for_rates(std::move(map));
    return;
  }
  if (increments && rather_factor(factors.gyro, as_increments) && rather_factor(factors.accel, as_increments)) {
    rename(map, "dtheta", "gyro", "rad/s");
    rename(map, "dvel", "accel", "m/s^2");
    return;
  }
  if (!increments && match.turn_ratio > 0) {
    if (const std::string unit = count_unit(map.find("gyro")->unit, match.turn_ratio); !unit.empty())
      map.uses.find("gyro")->second.unit = unit;
  }
  if (factors.gyro == kDegree || factors.gyro == kDegreesPerRadian) {
    const std::string unit = factors.gyro == kDegree ? "deg" : "rad";
    std::string& present = map.uses.find(increments ? "dtheta" : "gyro")->second.unit;
    present = with_number_of(present, increments ? unit : unit + "/s");
  }
  if (increments) return;
  std::string& force = map.uses.find("accel")->second.unit;
  if (near_factor(factors.accel, kStandardGravity)) force = with_number_of(force, "g");
  if (near_factor(factors.accel, 1 / kStandardGravity)) force = with_number_of(force, "m/s^2");
}

}  // namespace

ColumnMap increments_for_rates(ColumnMap map) {
  rename(map, "gyro", "dtheta", "rad");
  rename(map, "accel", "dvel", "m/s");
  return map;
}

std::optional<ColumnMap> repaired(const ColumnMap& map, const LogMatch& match) {
  if (match.interval == 0 || !match.clock) return std::nullopt;
  ColumnMap changed = map;
  scale_rates(changed, match);
  if (match.motion && match.motion->gravity && !match.motion->track_mirrored()) {
    // Mirrored forces: reverse their sign, then turn them as fitted.
    const bool increments = changed.find("dtheta") != nullptr;
    const Matrix3d sign = match.motion->mirrored ? Matrix3d(-Matrix3d::Identity()) : Matrix3d::Identity();
    turn(changed.uses.find(increments ? "dtheta" : "gyro")->second, match.motion->gyro_axes, kSensorAxes);
    turn(changed.uses.find(increments ? "dvel" : "accel")->second, sign, kSensorAxes);
  }
  return changed == map ? std::nullopt : std::optional(std::move(changed));
}

std::optional<ColumnMap> repaired(const ColumnMap& map, const VelocityFit& fit) {
  if (fit.as_given()) return std::nullopt;
  ColumnMap changed = map;
  if (fit.interchanged) std::swap(changed.uses.find("latitude")->second, changed.uses.find("longitude")->second);
  for (const std::string_view key : {"velocity", "sigma_velocity", "speed", "speed_accuracy"}) {
    const auto use = changed.uses.find(key);
    if (use == changed.uses.end()) continue;
    if (fit.scale != 1) use->second.unit = speed_unit_text(fit.scale);
    if (key == "velocity" || (key == "sigma_velocity" && use->second.names.size() > 1)) {
      if (!turn(use->second, fit.axes.transpose(), kLevelAxes)) return std::nullopt;
    }
  }
  return changed == map ? std::nullopt : std::optional(std::move(changed));
}

bool is_mended_by_columns(LogFault fault) {
  switch (fault) {
    case LogFault::kIncrementsForRates:
    case LogFault::kRatesForIncrements:
    case LogFault::kGyroDegrees:
    case LogFault::kGyroRadians:
    case LogFault::kAccelG:
    case LogFault::kAccelMetres:
    case LogFault::kAccelSign:
    case LogFault::kAxesMirrored:
    case LogFault::kGyroAxes:
    case LogFault::kLatitudeLongitude:
    case LogFault::kVelocityEastNorth:
    case LogFault::kVelocityUp:
    case LogFault::kVelocityUnit:
      return true;
    default:
      return false;
  }
}

}  // namespace piste
