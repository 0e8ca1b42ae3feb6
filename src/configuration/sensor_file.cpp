#include "piste/configuration/sensor_file.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <sstream>
#include <system_error>
#include <utility>
#include <vector>

#include "core/installed.h"
#include "io/triad_units.h"
#include "piste/math/units.h"

namespace piste {
namespace {

using Kind = DriftProcess::Kind;

double positive(const Config& config, std::string_view key, const Dimension& expected) {
  const double value = config.quantity(key, expected);
  if (!(value > 0)) config.fail(key, fmt::format("must be above zero, such as `{}`", expected.example));
  return value;
}

DriftProcess read_drift(const Config& config, const TriadUnits& units) {
  DriftProcess drift;
  drift.kind = config.choice<Kind>(
      "process", {{"none", Kind::kNone}, {"random_walk", Kind::kRandomWalk}, {"gauss_markov", Kind::kGaussMarkov}});
  if (drift.kind == Kind::kGaussMarkov) {
    drift.sigma = positive(config, "sigma", units.value);
    drift.correlation_time = positive(config, "correlation_time", dimension::kTime);
  } else if (drift.kind == Kind::kRandomWalk) {
    drift.density = positive(config, "density", units.drift);
  }
  return drift;
}

// One value, or one for each axis.
void read_noise(const Config& config, const TriadUnits& units, TriadErrors& errors) {
  std::istringstream words(config.text("noise"));
  double first = 0, second = 0;
  if (!(words >> first >> second)) {
    errors.noise = positive(config, "noise", units.noise);
    return;
  }
  const Vector3d axes = config.vector("noise", units.noise);
  if (!(axes.minCoeff() > 0))
    config.fail("noise", fmt::format("must be above zero on each axis, such as `{}`", units.noise.example));
  errors.set_densities(axes);
}

std::string noise_text(const TriadErrors& errors, const TriadUnits& units) {
  const auto text = [&](double value) { return format_quantity(value, units.noise_unit, units.noise); };
  if (errors.axes == Vector3d::Ones()) return text(errors.noise);
  const double factor = unit_factor(units.noise_unit, units.noise);
  const Vector3d axes = errors.noise / factor * errors.axes;
  return fmt::format("{:.10g} {:.10g} {:.10g} {}", axes.x(), axes.y(), axes.z(), units.noise_unit);
}

TriadErrors read_triad(const Config& config, const TriadUnits& units) {
  TriadErrors errors;
  read_noise(config, units, errors);
  errors.bias = config.magnitude("bias", units.value, 0);
  if (const auto drift = config.find_map("drift")) errors.drift = read_drift(*drift, units);
  errors.scale = config.magnitude("scale", dimension::kRatio, 0);
  if (config.has("cross_axis")) errors.cross_axis = config.magnitude("cross_axis", dimension::kRatio);
  errors.range = config.magnitude("range", units.value, 0);
  return errors;
}

std::string drift_text(const DriftProcess& drift, const TriadUnits& units) {
  switch (drift.kind) {
    case Kind::kNone:
      break;
    case Kind::kRandomWalk:
      return fmt::format("{{process: random_walk, density: {}}}",
                         format_quantity(drift.density, units.drift_unit, units.drift));
    case Kind::kGaussMarkov:
      return fmt::format("{{process: gauss_markov, sigma: {}, correlation_time: {}}}",
                         format_quantity(drift.sigma, units.value_unit, units.value),
                         format_quantity(drift.correlation_time, "s", dimension::kTime));
  }
  return "{process: none}";
}

std::string triad_text(std::string_view name, const TriadErrors& errors, const TriadUnits& units) {
  std::string text =
      fmt::format("{}:\n  noise: {}\n  bias: {}\n  drift: {}\n  scale: {}\n", name, noise_text(errors, units),
                  format_quantity(errors.bias, units.value_unit, units.value), drift_text(errors.drift, units),
                  format_quantity(errors.scale, "ppm", dimension::kRatio));
  if (errors.cross_axis) {
    text += fmt::format("  cross_axis: {}\n", format_quantity(*errors.cross_axis, "ppm", dimension::kRatio));
  }
  if (errors.range > 0) {
    text += fmt::format("  range: {}\n", format_quantity(errors.range, units.value_unit, units.value));
  }
  return text;
}

}  // namespace

std::filesystem::path sensor_file(const Config& config, std::string_view key) {
  namespace fs = std::filesystem;
  std::error_code unreachable;
  const std::string name = config.text(key);
  if (name.find_first_of("/.") != std::string::npos || fs::is_regular_file(config.path(key), unreachable)) {
    return config.existing_file(key);
  }
  const fs::path folder = shared_folder() / "sensors";
  fs::path shared = folder / (name + ".yaml");
  if (fs::is_regular_file(shared, unreachable)) return shared;
  std::vector<std::string> names;
  for (const auto& entry : fs::directory_iterator(folder, unreachable)) names.push_back(entry.path().stem().string());
  std::sort(names.begin(), names.end());
  config.fail(
      key, fmt::format("there is no file `{}`, and no sensor of that name in {}{}", config.path(key).string(),
                       folder.string(), names.empty() ? "" : fmt::format("; there are: {}", fmt::join(names, ", "))));
}

ImuSensor read_sensor(const std::filesystem::path& file) { return read_sensor(Config::load(file)); }

ImuSensor read_sensor(const Config& config) {
  ImuSensor sensor;
  sensor.name = config.text("name");
  const Config gyro = config.map("gyro");
  sensor.gyro = read_triad(gyro, kGyroUnits);
  if (gyro.has("g_sensitivity")) {
    sensor.gyro_g_sensitivity = gyro.magnitude("g_sensitivity", dimension::kGSensitivity);
  }
  sensor.accel = read_triad(config.map("accel"), kAccelUnits);
  config.finish();
  return sensor;
}

ImuSensor rounded(ImuSensor sensor, int digits) {
  const auto round = [](double& value, std::string_view unit, const Dimension& dimension, int to) {
    if (value == 0 || !std::isfinite(value)) return;
    const double factor = unit_factor(unit, dimension), shown = value / factor;
    const double last = std::pow(10.0, to - 1 - std::floor(std::log10(std::abs(shown))));
    value = std::round(shown * last) / last * factor;
  };
  for (const auto& [triad, units] : {std::pair{&sensor.gyro, &kGyroUnits}, std::pair{&sensor.accel, &kAccelUnits}}) {
    if (triad->axes == Vector3d::Ones()) {
      round(triad->noise, units->noise_unit, units->noise, digits);
    } else {
      Vector3d densities = triad->densities();
      for (double& density : densities) round(density, units->noise_unit, units->noise, digits);
      triad->set_densities(densities);
    }
    for (double* value : {&triad->bias, &triad->drift.sigma}) round(*value, units->value_unit, units->value, digits);
    round(triad->drift.density, units->drift_unit, units->drift, digits);
    round(triad->drift.correlation_time, "s", dimension::kTime, digits);
    if (triad->cross_axis) round(*triad->cross_axis, "ppm", dimension::kRatio, digits);
    round(triad->range, units->value_unit, units->value, 4);
  }
  return sensor;
}

std::string sensor_text(const ImuSensor& sensor) {
  std::string text = fmt::format("name: {}\n", yaml_text(sensor.name)) + triad_text("gyro", sensor.gyro, kGyroUnits);
  if (sensor.gyro_g_sensitivity) {
    text += fmt::format("  g_sensitivity: {}\n",
                        format_quantity(*sensor.gyro_g_sensitivity, "deg/s/g", dimension::kGSensitivity));
  }
  return text + triad_text("accel", sensor.accel, kAccelUnits);
}

}  // namespace piste
