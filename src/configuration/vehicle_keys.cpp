#include "configuration/vehicle_keys.h"

#include "math/magnetic_field.h"

namespace piste {
namespace {

// 1-sigma of a contact point that the user has measured [m].
constexpr double kMeasured = 0.3;
// Years before the model's first one for which it may be asked: it is then wrong by 0.3 deg and less in most places.
constexpr double kOlder = 10;

void require_positive(const Config& map, std::string_view key, const Vector3d& sigma, std::string_view example) {
  if (!(sigma.minCoeff() > 0)) map.fail(key, "must be above zero, such as `" + std::string(example) + "`");
}

// The file of a sensor of one number a row, and its `sigma` if it is stated.
LogFile read_aid(const Config& map, const Dimension& dimension, std::string_view example,
                 std::initializer_list<LogFormat> formats = {LogFormat::kCsv}) {
  LogFile log = read_log_file(map, formats);
  if (!map.has("sigma")) return log;
  log.sigma = Vector3d::Constant(map.quantity("sigma", dimension));
  require_positive(map, "sigma", *log.sigma, example);
  return log;
}

}  // namespace

GaussMarkov read_process(const Config& config, std::string_view key, const Dimension& value, GaussMarkov otherwise) {
  const auto map = config.find_map(key);
  if (!map) return otherwise;
  GaussMarkov process = otherwise;
  process.sigma.x() = map->magnitude("sigma", value);
  process.correlation_time = map->quantity("correlation_time", dimension::kTime);
  if (!(process.correlation_time > 0)) map->fail("correlation_time", "must be above zero, such as `60 s`");
  return process;
}

VehicleOptions vehicle_of(VehicleOptions::Kind kind) {
  VehicleOptions vehicle;
  vehicle.kind = kind;
  if (kind == VehicleOptions::Kind::kBicycle) vehicle.pitch_centre_sigma = vehicle.dive_sigma = 0;
  return vehicle;
}

std::optional<VehicleOptions> read_vehicle(const Config& config) {
  if (!config.has("vehicle")) return std::nullopt;
  if (config.is_scalar("vehicle")) {
    if (config.text("vehicle") != "off") {
      config.fail("vehicle", "a map is expected, such as `{kind: car, mounting: auto}`, or `off`");
    }
    return std::nullopt;
  }
  const Config map = config.map("vehicle");
  using Carrier = VehicleOptions::Kind;
  VehicleOptions vehicle =
      vehicle_of(map.choice<Carrier>("kind", {{"car", Carrier::kCar}, {"bicycle", Carrier::kBicycle}}));
  if (map.has("contact")) {
    vehicle.contact = map.vector("contact", dimension::kLength);
    vehicle.contact_sigma = Vector3d::Constant(kMeasured);
  } else if (vehicle.kind == Carrier::kBicycle) {
    map.fail({},
             "`contact` is missing: from the IMU to where the rear wheel touches the ground, forward, right, down, "
             "such as `contact: -0.5 0 0.9 m`; a bicycle leans, and its sway there is not that of the IMU");
  }
  if (map.has("sigma_contact")) {
    vehicle.contact_sigma = map.vector("sigma_contact", dimension::kLength);
    require_positive(map, "sigma_contact", vehicle.contact_sigma, "0.3 0.3 0.3 m");
  }
  if (map.text("mounting", "auto") != "auto") {
    const Vector3d angles = map.vector("mounting", dimension::kAngle);
    vehicle.mounting = from_euler(angles);
  }
  if (map.has("sigma_mounting")) {
    if (!vehicle.mounting) map.fail("sigma_mounting", "`mounting: auto` finds its own sigmas; leave the key out");
    vehicle.mounting_sigma = map.vector("sigma_mounting", dimension::kAngle);
    require_positive(map, "sigma_mounting", vehicle.mounting_sigma, "2 2 2 deg");
  }
  vehicle.slip = read_process(map, "slip", dimension::kVelocity, vehicle.slip);
  return vehicle;
}

std::optional<LogFile> read_odometer(const Config& config, FilterOptions& filter) {
  const auto map = config.find_map("odometer");
  if (!map) return std::nullopt;
  if (!filter.vehicle) {
    config.fail("odometer", "a wheel measures along a vehicle; add `vehicle: {kind: car}`, or leave `odometer` out");
  }
  LogFile log = read_aid(*map, dimension::kVelocity, "0.1 m/s");
  OdometerOptions odometer;
  odometer.scale_sigma = map->magnitude("scale", dimension::kRatio, odometer.scale_sigma);
  odometer.slip = read_process(*map, "slip", dimension::kVelocity, odometer.slip);
  odometer.is_signed = map->flag("signed", odometer.is_signed);
  filter.odometer = odometer;
  return log;
}

std::optional<LogFile> read_barometer(const Config& config, FilterOptions& filter) {
  const auto map = config.find_map("barometer");
  if (!map) return std::nullopt;
  LogFile log = read_aid(*map, dimension::kLength, "0.5 m");
  BarometerOptions barometer;
  if (const auto drift = map->find_map("drift")) {
    barometer.offset.sigma.x() = drift->quantity("sigma", dimension::kLength);
    barometer.offset.correlation_time = drift->quantity("correlation_time", dimension::kTime);
    if (!(barometer.offset.sigma.x() > 0)) drift->fail("sigma", "must be above zero, such as `100 m`");
    if (!(barometer.offset.correlation_time > 0))
      drift->fail("correlation_time", "must be above zero, such as `36000 s`");
  }
  filter.barometer = barometer;
  return log;
}

std::optional<LogFile> read_dual_heading(const Config& config, FilterOptions& filter) {
  const auto map = config.find_map("heading");
  if (!map) return std::nullopt;
  LogFile log = read_aid(*map, dimension::kAngle, "0.5 deg",
                         {LogFormat::kCsv, LogFormat::kUbx, LogFormat::kNovatel, LogFormat::kNmea});
  DualHeadingOptions heading;
  heading.baseline = map->vector("baseline", dimension::kLength, heading.baseline);
  if (!(heading.baseline.norm() > 0)) map->fail("baseline", "two antennas stand apart, such as `1 0 0 m`");
  filter.heading = heading;
  return log;
}

MagneticConditioning read_magnetometer(const Config& config, FilterOptions& filter) {
  using namespace dimension;
  constexpr double kMicro = 1e6;
  MagneticConditioning conditioning;
  const auto map = config.find_map("magnetometer");
  if (!map) return conditioning;
  MagnetometerOptions options;
  const auto field = [&](const Config& section, std::string_view key, double fallback, std::string_view example) {
    if (!section.has(key)) return fallback;
    const double value = kMicro * section.quantity(key, kMagneticField);
    if (!(value > 0)) section.fail(key, "must be above zero, such as `" + std::string(example) + "`");
    return value;
  };
  options.sigma = field(*map, "sigma", options.sigma, "0.5 uT");
  options.hard_iron = kMicro * map->magnitude("hard_iron", kMagneticField, options.hard_iron / kMicro);
  options.soft_iron = map->magnitude("soft_iron", kRatio, options.soft_iron);
  if (const auto disturbance = map->find_map("disturbance")) {
    options.disturbance.sigma = Vector3d::Constant(kMicro * disturbance->quantity("sigma", kMagneticField));
    if (!(options.disturbance.sigma.x() > 0)) disturbance->fail("sigma", "must be above zero, such as `1 uT`");
    options.disturbance.correlation_time = disturbance->quantity("correlation_time", kTime);
    if (!(options.disturbance.correlation_time > 0))
      disturbance->fail("correlation_time", "must be above zero, such as `10 s`");
  }
  conditioning.unit = field(*map, "unit", conditioning.unit, "1 uT");
  conditioning.year = map->number("year", conditioning.year);
  if (!(conditioning.year >= kMagneticFirstYear - kOlder && conditioning.year <= kMagneticLastYear)) {
    map->fail("year",
              "the World Magnetic Model is that of 2025 to 2030; a year such as 2026.5 is expected, or state "
              "the `field`");
  }
  if (map->has("field")) conditioning.field = kMicro * map->vector("field", kMagneticField);
  if (map->has("declination")) conditioning.declination = map->quantity("declination", kAngle);
  conditioning.interval = map->magnitude("interval", kTime, kMagneticInterval);
  filter.magnetometer = options;
  return conditioning;
}

}  // namespace piste
