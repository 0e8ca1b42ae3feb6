#include "piste/sim/replay_setup.h"

#include <fmt/format.h>

#include <algorithm>
#include <string>
#include <string_view>

#include "configuration/replay_keys.h"
#include "configuration/vehicle_keys.h"
#include "piste/configuration/sensor_file.h"
#include "piste/core/error.h"
#include "piste/core/options.h"
#include "piste/io/config.h"
#include "piste/sim/scenario.h"
#include "sim/names.h"

namespace piste {
namespace {

using namespace dimension;

// Indices in `setups` of those that `key` names. Empty if the key is missing.
template <class Setup>
std::vector<std::size_t> read_sensors(const Config& config, std::string_view key, const std::vector<Setup>& setups) {
  std::vector<std::size_t> found;
  for (const std::string& name : config.words(key)) {
    const std::size_t place = place_of(config, key, name, setups);
    if (std::find(found.begin(), found.end(), place) != found.end()) {
      config.fail(key, fmt::format("`{}` stands twice", name));
    }
    found.push_back(place);
  }
  return found;
}

double positive(const Config& config, std::string_view key, const Dimension& expected, double fallback) {
  const double value = config.quantity(key, expected, fallback);
  if (!(value > 0)) config.fail(key, fmt::format("must be above zero, such as `{}`", expected.example));
  return value;
}

StartSigmas read_start(const Config& config) {
  StartSigmas s;
  s.position = positive(config, "position", kLength, s.position);
  s.velocity = positive(config, "velocity", kVelocity, s.velocity);
  s.tilt = positive(config, "tilt", kAngle, s.tilt);
  s.heading = positive(config, "heading", kAngle, s.heading);
  return s;
}

// The filter's model of the IMU, or of several and of their mean.
void read_stated_sensors(const Config& config, const Scenario& scenario, ReplaySetup& setup) {
  std::optional<ImuSensor> stated;
  if (config.has("sensor")) stated = read_sensor(sensor_file(config, "sensor"));
  setup.sensor = stated.value_or(scenario.imus[setup.imu].sensor);
  if (setup.further.empty()) return;
  const ImuSetup& first = scenario.imus[setup.imu];
  const auto add = [&](const ImuSetup& imu) {
    setup.imus.push_back(turned(stated.value_or(imu.sensor), (first.q_rb.conjugate() * imu.q_rb).toRotationMatrix()));
  };
  add(first);
  for (const std::size_t i : setup.further) add(scenario.imus[i]);
  try {
    setup.sensor = mean_sensor(setup.imus);
  } catch (const ConfigError& e) {
    config.fail("imu", e.what());
  }
}

std::vector<Block> read_blocks(const Config& config, const Scenario& scenario, const ReplaySetup& setup) {
  FilterOptions filter;
  filter.sensor = setup.sensor;
  filter.imus = setup.imus;
  const ImuSetup& imu = scenario.imus[setup.imu];
  set_aids(filter, scenario, imu);
  for (const std::size_t i : setup.gnss) {
    filter.gnss.push_back({.name = scenario.gnss[i].name,
                           .use_velocity = scenario.gnss[i].velocity_noise.maxCoeff() > 0,
                           .drift = scenario.gnss[i].position_drift});
  }
  for (const std::size_t i : setup.attitude) {
    filter.attitude.push_back({.name = scenario.attitude[i].name, .drift = scenario.attitude[i].drift});
  }
  std::vector<Block> usual = imu_error_blocks(filter.sensor);
  if (!setup.attitude.empty()) usual.push_back(Block::kBoresight);
  filter.estimate = read_estimate(config, filter, std::move(usual));
  try {
    filter.validate();
  } catch (const ConfigError& e) {
    throw ConfigError(config.where("gnss"), e.what());
  }
  return filter.estimate;
}

std::vector<Interval> read_outages(const Config& config, const MotionOptions& motion) {
  std::vector<Interval> outages = read_outages(config);
  for (const Interval& o : outages) {
    if (o.start < -motion.rest_before || o.end > motion.run + motion.rest_after) {
      config.fail("outages", fmt::format("[{}, {}] leaves the recording, which lasts from {} s before the departure to "
                                         "{} s after it",
                                         o.start, o.end - o.start, motion.rest_before, motion.run + motion.rest_after));
    }
  }
  return outages;
}

}  // namespace

void set_aids(FilterOptions& filter, const Scenario& scenario, const ImuSetup& imu) {
  const AidSetups& aids = scenario.aids;
  if (aids.vehicle) {
    VehicleOptions vehicle = vehicle_of(*aids.vehicle);
    const TrueMounting mounting = true_mounting(scenario.q_tr, imu.q_rb, imu.p_rb_r);
    vehicle.mounting = mounting.q_vb;
    vehicle.contact = mounting.contact;
    filter.vehicle = vehicle;
  }
  if (aids.odometer) filter.odometer = aids.odometer->errors;
  if (aids.barometer) filter.barometer = aids.barometer->errors;
  if (aids.heading) {
    filter.heading = aids.heading->errors;
    filter.heading->baseline = imu.q_rb.conjugate() * filter.heading->baseline;
  }
  if (imu.magnetic_field) filter.magnetometer = imu.magnetometer;
}

ReplaySetup read_replay_setup(const Config& file, const Scenario& scenario) {
  const auto section = file.find_map("montecarlo");
  const Config config = section.value_or(Config::parse("{}", file.file()));
  ReplaySetup s;
  if (config.has("imu")) {
    const auto imus = read_sensors(config, "imu", scenario.imus);
    if (imus.empty() || imus.size() > kMostImus) {
      config.fail("imu", fmt::format("one IMU is expected, or a list of up to {} that are taken as one", kMostImus));
    }
    s.imu = imus.front();
    s.further.assign(imus.begin() + 1, imus.end());
  }
  s.gnss = read_sensors(config, "gnss", scenario.gnss);
  if (config.has("gnss") && s.gnss.empty()) config.fail("gnss", "name at least one receiver");
  if (section && scenario.gnss.empty()) file.fail("montecarlo", "needs a receiver; add `gnss:` to the scenario");
  if (s.gnss.empty() && !scenario.gnss.empty()) s.gnss = {0};
  s.attitude = read_sensors(config, "attitude", scenario.attitude);
  read_stated_sensors(config, scenario, s);
  s.estimate = read_blocks(config, scenario, s);
  s.adapt = read_adaptation(config);

  using Heading = ReplaySetup::Heading;
  s.heading = config.choice<Heading>("heading", {{"known", Heading::kKnown}, {"auto", Heading::kAuto}}, s.heading);
  s.random_headings = config.choice<bool>("headings", {{"as_given", false}, {"random", true}}, s.random_headings);
  s.smoother = config.choice<SmootherKind>("smoother", {{"rts", SmootherKind::kRts}, {"batch", SmootherKind::kBatch}},
                                           s.smoother);
  // With an unknown heading, `start` is not read, so that finish() reports it as a key without use.
  if (config.has("start") && s.heading == Heading::kKnown) s.start = read_start(config.map("start"));
  s.outages = read_outages(config, scenario.motion);
  const double whole = scenario.motion.run + scenario.motion.rest_after;
  s.end = std::min(positive(config, "end", kTime, whole), whole);
  s.every = positive(config, "every", kTime, s.every);
  return s;
}

}  // namespace piste
