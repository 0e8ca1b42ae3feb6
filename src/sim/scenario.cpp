#include "piste/sim/scenario.h"

#include <fmt/format.h>

#include <set>

#include "configuration/vehicle_keys.h"
#include "math/magnetic_field.h"
#include "piste/configuration/sensor_file.h"
#include "piste/core/error.h"
#include "piste/io/config.h"
#include "piste/math/units.h"
#include "sim/names.h"

namespace piste {
namespace {

using namespace dimension;

// An optional vector: nothing where the key is absent.
std::optional<Vector3d> find_vector(const Config& config, std::string_view key, const Dimension& expected) {
  if (!config.has(key)) return std::nullopt;
  return config.vector(key, expected);
}

// The spread about the value that `key` gives.
Vector3d read_spread(const Config& config, const std::string& key, const Dimension& expected) {
  const std::string spread_key = key + "_spread";
  Vector3d spread = config.vector(spread_key, expected, Vector3d::Zero());
  if (spread.minCoeff() < 0) config.fail(spread_key, "must not be negative; it is a sigma of each axis");
  if (config.has(spread_key) && !config.has(key)) {
    config.fail(spread_key, fmt::format("spreads about `{0}`, which is missing; give `{0}` too, or neither: then it is "
                                        "drawn with the sigma of the sensor file",
                                        key));
  }
  return spread;
}

// `value` is the dimension of the signal, `integral` that of its integral.
TriadTruth read_triad(const Config& config, const Dimension& value, const Dimension& integral) {
  TriadTruth t;
  t.bias = find_vector(config, "bias", value);
  t.bias_spread = read_spread(config, "bias", value);
  t.scale = find_vector(config, "scale", kRatio);
  t.scale_spread = read_spread(config, "scale", kRatio);
  if (config.has("misalignment")) t.misalignment = config.magnitude("misalignment", kRatio);
  t.warm_up = config.vector("warm_up", value, t.warm_up);
  t.warm_up_time = config.magnitude("warm_up_time", kTime, t.warm_up_time);
  if (t.warm_up_time <= 0) config.fail("warm_up_time", "must be above zero, such as `120 s`");
  t.quantization = config.magnitude("quantization", integral, t.quantization);
  return t;
}

std::optional<GaussMarkov> read_drift(const Config& config, std::string_view key, const Dimension& value) {
  const auto map = config.find_map(key);
  if (!map) return std::nullopt;
  const GaussMarkov drift{map->vector("sigma", value), map->magnitude("correlation_time", kTime)};
  if (drift.correlation_time <= 0) map->fail("correlation_time", "must be above zero, such as `60 s`");
  return drift;
}

double read_rate(const Config& config, double fallback) {
  const double rate = config.magnitude("rate", kFrequency, fallback);
  if (rate <= 0) config.fail("rate", "must be above zero, such as `100 Hz`");
  return rate;
}

void read_magnetometer(const Config& config, const Geodetic& origin, ImuSetup& s) {
  constexpr double kMicro = 1e6;
  if (config.has("field")) {
    s.magnetic_field = kMicro * config.vector("field", kMagneticField);
  } else {
    s.magnetic_field = magnetic_field(origin, config.number("year", MagneticConditioning().year));
  }
  s.magnetometer.sigma = kMicro * config.magnitude("noise", kMagneticField, 0);
  s.magnetometer.hard_iron = kMicro * config.magnitude("hard_iron", kMagneticField, 0);
  s.magnetometer.soft_iron = config.magnitude("soft_iron", kRatio, 0);
  if (const auto disturbance = read_drift(config, "disturbance", kMagneticField)) {
    s.magnetometer.disturbance = {kMicro * disturbance->sigma, disturbance->correlation_time};
  }
}

ImuSetup read_imu(const Config& config, const Geodetic& origin, std::set<std::string>& names) {
  using Sampling = ImuSetup::Sampling;
  ImuSetup s;
  s.name = claim_name(names, config);
  s.sensor_file = sensor_file(config, "sensor");
  s.sensor = read_sensor(s.sensor_file);
  s.q_rb = from_euler(config.vector("boresight", kAngle, Vector3d::Zero()));
  s.p_rb_r = config.vector("position", kLength, s.p_rb_r);
  s.rate = read_rate(config, s.rate);
  s.sampling = config.choice<Sampling>(
      "sampling", {{"mean", Sampling::kMean}, {"instant", Sampling::kInstant}, {"increments", Sampling::kIncrements}},
      s.sampling);
  if (const auto clock = config.find_map("clock")) {
    s.clock_offset = clock->quantity("offset", kTime, 0);
    s.clock_drift = clock->quantity("drift", kRatio, 0);
  }
  if (const auto errors = config.find_map("errors")) {
    if (const auto gyro = errors->find_map("gyro")) s.gyro = read_triad(*gyro, kAngularRate, kAngle);
    if (const auto accel = errors->find_map("accel")) s.accel = read_triad(*accel, kAcceleration, kVelocity);
  }
  if (const auto magnetometer = config.find_map("magnetometer")) {
    read_magnetometer(*magnetometer, origin, s);
  }
  return s;
}

GnssSetup read_gnss(const Config& config, std::set<std::string>& names) {
  GnssSetup s;
  s.name = claim_name(names, config);
  s.p_ra_r = config.vector("lever_arm", kLength, s.p_ra_r);
  s.rate = read_rate(config, s.rate);
  s.position_noise = config.vector("position_noise", kLength, s.position_noise);
  s.position_drift = read_drift(config, "position_drift", kLength);
  s.velocity_noise = config.vector("velocity_noise", kVelocity, s.velocity_noise);
  s.delay = config.quantity("delay", kTime, s.delay);
  if (config.has("velocity_delay")) {
    s.velocity_delay = config.quantity("velocity_delay", kTime);
    if (!(s.velocity_noise.maxCoeff() > 0)) {
      config.fail("velocity_delay", "a receiver whose `velocity_noise` is 0 gives no velocity; leave the key out");
    }
  }
  return s;
}

AttitudeSetup read_attitude(const Config& config, std::set<std::string>& names) {
  AttitudeSetup s;
  s.name = claim_name(names, config);
  s.rate = read_rate(config, s.rate);
  s.noise = config.vector("noise", kAngle, s.noise);
  s.drift = read_drift(config, "drift", kAngle);
  s.delay = config.quantity("delay", kTime, s.delay);
  return s;
}

// White noise of a fix, which the fix states as its sigma.
double read_noise(const Config& config, const Dimension& expected, double fallback) {
  const double noise = config.quantity("noise", expected, fallback);
  if (!(noise > 0)) config.fail("noise", fmt::format("must be above zero, such as `{}`", expected.example));
  return noise;
}

AidSetups read_aids(const Config& config, std::set<std::string>& names) {
  AidSetups aids;
  const auto find = [&](const char* key) {
    auto map = config.find_map(key);
    if (map && !names.insert(key).second) config.fail(key, fmt::format("`{}` is taken; rename the other sensor", key));
    return map;
  };
  using Carrier = VehicleOptions::Kind;
  if (const auto map = config.find_map("vehicle")) {
    aids.vehicle = map->choice<Carrier>("kind", {{"car", Carrier::kCar}, {"bicycle", Carrier::kBicycle}});
  }
  if (const auto map = find("odometer")) {
    OdometerSetup& s = aids.odometer.emplace();
    if (!aids.vehicle) config.fail("odometer", "a wheel is that of a vehicle; add `vehicle: {kind: car}`");
    s.rate = read_rate(*map, s.rate);
    s.errors.sigma = read_noise(*map, kVelocity, s.errors.sigma);
    s.errors.scale_sigma = map->magnitude("scale", kRatio, s.errors.scale_sigma);
    s.errors.slip = read_process(*map, "slip", kVelocity, s.errors.slip);
    s.errors.is_signed = map->flag("signed", s.errors.is_signed);
  }
  if (const auto map = find("barometer")) {
    BarometerSetup& s = aids.barometer.emplace();
    s.rate = read_rate(*map, s.rate);
    s.errors.sigma = read_noise(*map, kLength, s.errors.sigma);
    s.errors.offset = read_process(*map, "drift", kLength, s.errors.offset);
  }
  if (const auto map = find("heading")) {
    DualHeadingSetup& s = aids.heading.emplace();
    s.rate = read_rate(*map, s.rate);
    s.errors.sigma = read_noise(*map, kAngle, s.errors.sigma);
    s.pitch_noise = map->magnitude("pitch_noise", kAngle, s.pitch_noise);
    s.errors.baseline = map->vector("baseline", kLength, s.errors.baseline);
    if (!(s.errors.baseline.norm() > 0)) map->fail("baseline", "two antennas stand apart, such as `1 0 0 m`");
  }
  return aids;
}

CourseOptions read_course(const Config& config) {
  CourseOptions course;
  const long gates = config.integer("gates", course.gates);
  constexpr long kMost = 1000;
  if (gates < 2 || gates > kMost) {
    config.fail("gates", fmt::format("must lie between 2, a start and a finish, and {}", kMost));
  }
  course.gates = static_cast<int>(gates);
  course.offset = config.magnitude("offset", kLength, course.offset);
  course.speed = config.magnitude("speed", kRatio, course.speed);
  const long seed = config.integer("seed", static_cast<long>(course.seed));
  if (seed < 0) config.fail("seed", "must not be negative");
  course.seed = static_cast<std::uint64_t>(seed);
  return course;
}

}  // namespace

MotionOptions read_motion(const Config& config, MotionOptions m) {
  m.rest_before = config.magnitude("rest_before", kTime, m.rest_before);
  m.run = config.magnitude("run", kTime, m.run);
  m.rest_after = config.magnitude("rest_after", kTime, m.rest_after);
  m.start_time = config.magnitude("start_time", kTime, m.start_time);
  m.stop_time = config.magnitude("stop_time", kTime, m.stop_time);
  m.heading = config.quantity("heading", kAngle, m.heading);
  m.speed = config.magnitude("speed", kVelocity, m.speed);
  m.speed_swing = config.magnitude("speed_swing", kVelocity, m.speed_swing);
  m.speed_period = config.magnitude("speed_period", kTime, m.speed_period);
  m.net_turn = config.quantity("net_turn", kAngle, m.net_turn);
  m.slope = config.quantity("slope", kAngle, m.slope);
  m.cycle = config.magnitude("cycle", kTime, m.cycle);
  m.turn = config.magnitude("turn", kAngle, m.turn);
  m.turn_variation = config.magnitude("turn_variation", kRatio, m.turn_variation);
  m.lean = config.quantity("lean", kRatio, m.lean);
  m.crouch = config.quantity("crouch", kAngle, m.crouch);
  m.sway_velocity = config.vector("sway_velocity", kVelocity, m.sway_velocity);
  m.sway_rate = config.vector("sway_rate", kAngularRate, m.sway_rate);
  m.turning_rate = config.magnitude("turning_rate", kAngularRate, m.turning_rate);
  m.balance_rate = config.vector("balance_rate", kAngularRate, m.balance_rate);
  m.vibration = config.vector("vibration", kAcceleration, m.vibration);
  m.vibration_rate = config.vector("vibration_rate", kAngularRate, m.vibration_rate);
  try {
    m.validate();
  } catch (const ConfigError& e) {
    throw ConfigError(config.where(), e.what());
  }
  return m;
}

Scenario read_scenario(const std::filesystem::path& file) { return read_scenario(Config::load(file)); }

Scenario read_scenario(const Config& config) {
  Scenario s;
  s.file = config.file().string();
  s.text = config.source();
  const Config origin = config.map("origin");
  s.origin = {origin.quantity("latitude", kAngle), origin.quantity("longitude", kAngle),
              origin.quantity("height", kLength)};
  if (std::abs(s.origin.latitude) > std::acos(0.0)) origin.fail("latitude", "must lie between -90 and 90 deg");
  constexpr double kDeepest = -12e3, kHighest = 1e6;  // m: below every sea, above every balloon
  if (!(s.origin.height > kDeepest && s.origin.height < kHighest))
    origin.fail("height", "must lie between -12 and 1000 km");
  s.start_time = config.magnitude("start", kTime, 0);
  const long seed = config.integer("seed", 1);
  if (seed < 0) config.fail("seed", "must not be negative");
  s.seed = static_cast<std::uint64_t>(seed);
  s.motion = read_motion(config.map("motion"), {});
  if (const auto course = config.find_map("course")) {
    s.motion.course = read_course(*course);
    try {
      s.motion.validate();
    } catch (const ConfigError& e) {
      throw ConfigError(course->where(), e.what());
    }
  }
  s.q_tr = from_euler(config.vector("mounting", kAngle, Vector3d::Zero()));
  const long every = config.integer("truth_every", 1);
  if (every < 1) config.fail("truth_every", "must be 1 or more");
  s.truth_every = static_cast<std::size_t>(every);

  std::set<std::string> names{"truth"};
  for (const Config& imu : config.maps("imus")) {
    s.imus.push_back(read_imu(imu, s.origin, names));
  }
  if (s.imus.empty()) config.fail("imus", "name at least one IMU");
  for (const Config& gnss : config.maps("gnss")) {
    s.gnss.push_back(read_gnss(gnss, names));
  }
  for (const Config& attitude : config.maps("attitude")) {
    s.attitude.push_back(read_attitude(attitude, names));
  }
  s.aids = read_aids(config, names);
  s.replay = read_replay_setup(config, s);
  config.finish();
  return s;
}

}  // namespace piste
