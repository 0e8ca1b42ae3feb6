#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <initializer_list>
#include <optional>

#include "io/csv.h"
#include "log_formats.h"
#include "piste/math/earth.h"
#include "piste/math/units.h"

namespace piste::log_formats {
namespace {

constexpr std::array<std::string_view, 3> kXyz{"x", "y", "z"}, kNed{"north", "east", "down"},
    kEuler{"roll", "pitch", "heading"};

struct ColumnUnit {
  std::string_view suffix;
  double factor;
};

/// Three columns `PREFIX_AXIS_UNIT`, read in SI and radians.
struct Triad {
  std::array<std::size_t, 3> columns;
  ColumnUnit unit;
  Vector3d read(const CsvReader& csv) const {
    Vector3d value = unit.factor * Vector3d(csv[columns[0]], csv[columns[1]], csv[columns[2]]);
    if (!value.allFinite()) csv.text().fail("a value is not finite in SI units", RowFault::Kind::kNotFinite);
    return value;
  }
};

// The columns that are there, and those among them that are of the same quantity in a unit that is not known.
std::string columns_there(const CsvReader& csv, std::string_view prefix, std::string_view axis) {
  const std::string start = fmt::format("{}{}{}_", prefix, prefix.empty() ? "" : "_", axis);
  const auto other = std::ranges::find_if(csv.names(), [&](const auto& name) { return name.starts_with(start); });
  return fmt::format("{}; the columns are: {}",
                     other != csv.names().end() ? fmt::format("; `{}` is in a unit that is not known", *other) : "",
                     fmt::join(csv.names(), ", "));
}

std::string column_name(std::string_view prefix, std::string_view axis, std::string_view unit) {
  return fmt::format("{}{}{}{}{}", prefix, prefix.empty() ? "" : "_", axis, unit.empty() ? "" : "_", unit);
}

std::optional<Triad> find_triad(CsvReader& csv, std::string_view prefix, const std::array<std::string_view, 3>& axes,
                                std::initializer_list<ColumnUnit> units) {
  for (const ColumnUnit& unit : units) {
    const auto first = csv.find(column_name(prefix, axes[0], unit.suffix));
    if (!first) continue;
    return Triad{{*first, csv.column(column_name(prefix, axes[1], unit.suffix)),
                  csv.column(column_name(prefix, axes[2], unit.suffix))},
                 unit};
  }
  return std::nullopt;
}

Triad require_triad(CsvReader& csv, std::string_view prefix, const std::array<std::string_view, 3>& axes,
                    std::initializer_list<ColumnUnit> units) {
  if (const auto triad = find_triad(csv, prefix, axes, units)) return *triad;
  std::string choices;
  for (const ColumnUnit& unit : units) {
    choices += (choices.empty() ? "" : " or ") + column_name(prefix, axes[0], unit.suffix);
  }
  csv.fail(fmt::format("column {} is missing, and with it those of the other axes{}", choices,
                       columns_there(csv, prefix, axes[0])));
}

// The sigmas, which a file need not have if `stated` elsewhere.
std::optional<Triad> sigma_triad(CsvReader& csv, const std::array<std::string_view, 3>& axes, ColumnUnit unit,
                                 bool stated) {
  if (stated) return find_triad(csv, "sigma", axes, {unit});
  return require_triad(csv, "sigma", axes, {unit});
}

// Correlations of north and east, north and down, east and down, as a row has them.
Correlation checked(const Vector3d& stated, const RowSource& row) {
  if (!(stated.cwiseAbs().maxCoeff() <= 1)) row.fail("a correlation is expected between -1 and 1");
  Matrix3d all = Matrix3d::Identity();
  all(0, 1) = all(1, 0) = stated.x();
  all(0, 2) = all(2, 0) = stated.y();
  all(1, 2) = all(2, 1) = stated.z();
  return correlations(all);
}

}  // namespace

ImuRecording read_imu_csv(const LogFile& log, RowFaults* faults) {
  CsvReader csv(log);
  ImuRecording imu;
  imu.file = log.file;
  const auto time = csv.column("time_s");
  auto gyro = find_triad(csv, "gyro", kXyz, {{"rad_s", 1}, {"deg_s", kDegree}});
  std::optional<Triad> accel;
  if (gyro) {
    accel = require_triad(csv, "accel", kXyz, {{"m_s2", 1}, {"g", kStandardGravity}});
  } else if ((gyro = find_triad(csv, "dtheta", kXyz, {{"rad", 1}, {"deg", kDegree}}))) {
    accel = require_triad(csv, "dvel", kXyz, {{"m_s", 1}});
    imu.increments = true;
  } else {
    csv.fail("no gyroscope: columns gyro_x_rad_s, gyro_x_deg_s, or increments dtheta_x_rad, dtheta_x_deg are expected" +
             columns_there(csv, "gyro", kXyz[0]));
  }
  const auto magnetic = find_triad(csv, "mag", kXyz, {{"uT", 1}});
  const auto temperature = csv.find("temperature_degC");
  csv.finish_header(faults);

  const bool declared_radians = gyro->unit.factor == 1;
  IncreasingTime increasing(log.order());
  const auto row = [&] {
    const double t = increasing.next(csv[time], csv.text());
    const Vector3d rotation = gyro->read(csv), force = accel->read(csv);
    const auto field = magnetic ? std::optional(magnetic->read(csv)) : std::nullopt;
    const bool judged = declared_radians && is_for_use(faults);
    if (judged && !imu.increments) check_rate(rotation, csv.text());
    if (judged && imu.increments) check_turn(rotation, t, imu, csv.text());
    imu.time.push_back(t);
    imu.gyro.push_back(rotation);
    imu.accel.push_back(force);
    if (field) imu.magnetic.push_back(*field);
    if (temperature) imu.temperature.push_back(csv[*temperature]);
  };
  for_each_row(
      faults, [&] { return csv.next(); }, row);
  return imu;
}

GnssRecording read_gnss_csv(const LogFile& log, RowFaults* faults) {
  CsvReader csv(log);
  const auto time = csv.column("time_s"), latitude = csv.column("latitude_deg"),
             longitude = csv.column("longitude_deg"), height = csv.column("height_m");
  const auto sigma = sigma_triad(csv, kNed, {"m", 1}, log.sigma || !is_for_use(faults));
  const auto velocity = find_triad(csv, "velocity", kNed, {{"m_s", 1}});
  std::optional<Triad> sigma_velocity;
  if (velocity && log.sigma_velocity) {
    sigma_velocity = find_triad(csv, "sigma_velocity", kNed, {{"m_s", 1}});
  } else if (velocity) {
    sigma_velocity = require_triad(csv, "sigma_velocity", kNed, {{"m_s", 1}});
  }
  const auto correlated = find_triad(csv, "correlation", {"north_east", "north_down", "east_down"}, {{"", 1}});
  csv.finish_header(faults);

  GnssRecording gnss{log.file, {}};
  IncreasingTime increasing(log.order());
  const auto row = [&] {
    if (!has_coordinates(csv[latitude], csv[longitude])) {
      ++gnss.without_fix;
      return;
    }
    GeodeticFix fix;
    fix.time = increasing.next(csv[time], csv.text());
    fix.position = geodetic_degrees(csv[latitude], csv[longitude], csv[height]);
    fix.sigma_position = sigma ? sigma->read(csv) : unknown_sigma();
    if (correlated) fix.correlation = checked(correlated->read(csv), csv.text());
    if (velocity) fix.velocity = {velocity->read(csv), sigma_velocity ? sigma_velocity->read(csv) : Vector3d::Zero()};
    check_fix(fix, log, csv.text());
    gnss.fixes.push_back(fix);
  };
  for_each_row(
      faults, [&] { return csv.next(); }, row);
  return gnss;
}

AttitudeRecording read_attitude_csv(const LogFile& log, RowFaults* faults) {
  CsvReader csv(log);
  const auto time = csv.column("time_s");
  const Triad angles = require_triad(csv, "", kEuler, {{"deg", kDegree}});
  const auto sigma = sigma_triad(csv, kEuler, {"deg", kDegree}, log.sigma || !is_for_use(faults));
  csv.finish_header(faults);

  AttitudeRecording attitude{log.file, {}};
  IncreasingTime increasing(log.order());
  const auto row = [&] {
    EulerFix fix{increasing.next(csv[time], csv.text()), angles.read(csv), sigma ? sigma->read(csv) : unknown_sigma()};
    check_attitude(fix, log, csv.text());
    attitude.fixes.push_back(fix);
  };
  for_each_row(
      faults, [&] { return csv.next(); }, row);
  return attitude;
}

}  // namespace piste::log_formats
