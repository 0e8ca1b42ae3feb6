#include "piste/configuration/replay_config.h"

#include <fmt/format.h>

#include <algorithm>

#include "configuration/behaviour_keys.h"
#include "configuration/output_keys.h"
#include "configuration/replay_keys.h"
#include "configuration/vehicle_keys.h"
#include "piste/core/error.h"
#include "piste/io/config.h"

namespace piste {
namespace {

AttitudeOptions read_attitude_options(const Config& source, const LogFile& log) {
  AttitudeOptions options;
  options.name = std::filesystem::path(log.file).stem().string();
  const double correlation_time = source.magnitude("correlation_time", dimension::kTime, 0);
  if (correlation_time > 0) options.drift = GaussMarkov{Vector3d::Zero(), correlation_time};
  options.delay = source.quantity("delay", dimension::kTime, options.delay);
  if (const auto boresight = source.find_map("boresight")) {
    const GaussMarkov process{Vector3d::Constant(boresight->quantity("sigma", dimension::kAngle)),
                              boresight->quantity("correlation_time", dimension::kTime)};
    if (!(process.sigma.minCoeff() > 0)) boresight->fail("sigma", "must be above zero, such as `0.1 deg`");
    if (!(process.correlation_time > 0)) {
      boresight->fail("correlation_time",
                      "must be above zero, such as `100 s`; a boresight without the map is constant");
    }
    options.boresight_drift = process;
  }
  return options;
}

InitialHeading read_initial(const Config& config, FilterOptions& filter, MagneticConditioning& magnetic) {
  using Source = InitialHeading::Source;
  InitialHeading heading;
  const auto initial = config.find_map("initial");
  if (!initial) return heading;
  const std::string text = initial->text("heading", "auto");
  if (text == "from_attitude") {
    if (filter.attitude.empty()) initial->fail("heading", "from_attitude needs an `attitude:` source; or choose auto");
    heading.source = Source::kAttitude;
  } else if (text == "from_magnetometer") {
    heading.source = Source::kMagnetometer;
  } else if (text != "auto") {
    if (text.find_first_of("0123456789") == std::string::npos) {
      initial->fail("heading",
                    fmt::format("`{}` is none of: auto, from_attitude, from_magnetometer, or an angle such as "
                                "`123.4 deg`",
                                text));
    }
    heading.source = Source::kValue;
    heading.value = initial->quantity("heading", dimension::kAngle);
  }
  read_heading_search(*initial, heading.source == Source::kAuto, filter.behaviour.start);
  const bool has_sigma = heading.source == Source::kValue || heading.source == Source::kMagnetometer;
  if (has_sigma) heading.sigma = initial->magnitude("sigma", dimension::kAngle, heading.sigma);
  if (has_sigma && !(heading.sigma > 0)) initial->fail("sigma", "must be above zero, such as `2 deg`");
  if (heading.source == Source::kMagnetometer && initial->has("declination")) {
    magnetic.declination = initial->quantity("declination", dimension::kAngle);
  }
  return heading;
}

Priors read_priors(const Config& config) {
  Priors priors;
  const auto map = config.find_map("priors");
  if (!map) return priors;
  priors.boresight = map->magnitude("boresight", dimension::kAngle, priors.boresight);
  priors.lever_arm = map->magnitude("lever_arm", dimension::kLength, priors.lever_arm);
  priors.gnss_delay = map->magnitude("gnss_delay", dimension::kTime, priors.gnss_delay);
  priors.velocity_delay = map->magnitude("velocity_delay", dimension::kTime, priors.velocity_delay);
  priors.attitude_delay = map->magnitude("attitude_delay", dimension::kTime, priors.attitude_delay);
  priors.clock_drift = map->magnitude("clock_drift", dimension::kRatio, priors.clock_drift);
  return priors;
}

SmootherKind read_smoother(const Config& config) {
  return config.choice<SmootherKind>(
      "smoother", {{"none", SmootherKind::kNone}, {"rts", SmootherKind::kRts}, {"batch", SmootherKind::kBatch}},
      SmootherKind::kRts);
}

BatchOptions read_batch(const Config& config, SmootherKind smoother) {
  BatchOptions options;
  const auto batch = config.find_map("batch");
  if (!batch) return options;
  if (smoother != SmootherKind::kBatch) config.fail("batch", "is of use with `smoother: batch` alone");
  options.loss = batch->choice<BatchLoss>(
      "loss", {{"truncated", BatchLoss::kTruncated}, {"barron", BatchLoss::kBarron}, {"squared", BatchLoss::kSquared}},
      options.loss);
  options.bound = batch->number("bound", options.bound);
  if (!(options.bound > 0.5 && options.bound < 1)) batch->fail("bound", "must be a probability such as 0.999");
  options.longest_interval = batch->quantity("spacing", dimension::kTime, options.longest_interval);
  if (!(options.longest_interval > 0 && options.longest_interval <= 10)) {
    batch->fail("spacing", "must be above zero and at most 10 s");
  }
  return options;
}

// One of several IMUs: how it is mounted against the first.
FusedImuConditioning read_unit(const Config& config, ImuSource& source) {
  FusedImuConditioning unit;
  if (config.has("boresight")) {
    const Vector3d angles = config.vector("boresight", dimension::kAngle);
    source.conditioning.R_bs = (from_euler(angles).toRotationMatrix() * source.conditioning.R_bs).eval();
  }
  if (config.is_scalar("lever_arm") && config.text("lever_arm") == "auto") {
    unit.find_place = true;
  } else {
    unit.place = config.vector("lever_arm", dimension::kLength, Vector3d::Zero());
  }
  return unit;
}

// The IMU, or several of them on one body, of which the first is the body.
void read_imus(const Config& config, ReplayConfig& replay) {
  const std::vector<Config> imus = config.maps("imu");
  FilterOptions& filter = replay.filter;
  if (imus.size() <= 1) {
    replay.imu = read_imu_source(imus.empty() ? config.map("imu") : imus.front());
    filter.sensor = turned(replay.imu.sensor, replay.imu.conditioning.R_bs);
    return;
  }
  if (imus.size() > kMostImus) config.fail("imu", fmt::format("at most {} IMUs are taken as one", kMostImus));
  for (const Config& imu : imus) {
    ImuSource source = read_imu_source(imu);
    FusedImuConditioning unit;
    if (&imu == &imus.front()) {
      replay.imu = source;
    } else {
      refuse_repeated(imu, source.log, replay.imu.log);
      for (const ImuSource& other : replay.further) refuse_repeated(imu, source.log, other.log);
      unit = read_unit(imu, source);
      replay.further.push_back(source);
    }
    unit.name = std::filesystem::path(source.log.file).stem().string();
    unit.imu = source.conditioning;
    unit.sensor = turned(source.sensor, source.conditioning.R_bs);
    filter.imus.push_back(unit.sensor);
    filter.unit_axes.push_back(unit.imu.R_bs);
    replay.conditioning.imus.push_back(unit);
  }
  try {
    filter.sensor = mean_sensor(filter.imus);
  } catch (const ConfigError& e) {
    config.fail("imu", e.what());
  }
}

// A rate under `output`: a frequency, or the word `imu` for every epoch.
double read_rate(const Config& output, std::string_view key, double fallback) {
  if (!output.has(key)) return fallback;
  if (output.text(key) == "imu") return 0;
  const double rate = output.quantity(key, dimension::kFrequency);
  if (!(rate > 0)) output.fail(key, "must be above zero, such as `10 Hz`, or `imu` for every epoch");
  return rate;
}

OutputRates read_output(const Config& config) {
  OutputRates rates;
  if (const auto output = config.find_map("output")) {
    rates.navigation = read_rate(*output, "rate", rates.navigation);
    rates.biases = read_rate(*output, "biases", rates.biases);
  }
  if (const auto attitude = config.find_map("attitude_output")) {
    rates.attitude = attitude->quantity("rate", dimension::kFrequency, rates.attitude);
    if (!(rates.attitude > 0)) attitude->fail("rate", "must be above zero, such as `10 Hz`");
  }
  return rates;
}

bool has_velocities(const GnssRecording& receiver) {
  return std::any_of(receiver.fixes.begin(), receiver.fixes.end(), [](const auto& fix) { return fix.velocity; });
}

// Throws if a delay of velocities is given or to be estimated, and there are none; or if the log states that they are
// late, and the configuration does not state the delay.
void check_velocities(const std::vector<GnssRecording>& gnss, const FilterOptions& filter) {
  bool some = false;
  for (std::size_t i = 0; i < gnss.size(); ++i) {
    const bool there = has_velocities(gnss[i]);
    some = some || (there && filter.gnss[i].use_velocity);
    if (const double late = gnss[i].velocity_latency;
        there && late != 0 && filter.gnss[i].use_velocity && !filter.gnss[i].velocity_delay) {
      throw DataError(gnss[i].file + ":1", fmt::format("the log says that its velocities come {0:g} s late; state it: "
                                                       "`velocity_delay: {0:g} s`, or leave them out: `use: position`",
                                                       late));
    }
    if (there || !filter.gnss[i].velocity_delay) continue;
    throw DataError(gnss[i].file + ":1", "the log has no velocities for `velocity_delay`; leave the key out");
  }
  if (some || !StateLayout(filter.estimate).has(Block::kVelocityDelay)) return;
  throw DataError(gnss.front().file + ":1",
                  "the log has no velocities from which velocity_delay could be estimated; leave the block out");
}

// The line of the key with which a sentence about the options begins, such as `gnss drift: one receiver at most`.
std::string where_of(const Config& config, std::string_view sentence) {
  const std::string_view key = sentence.substr(0, sentence.find_first_of(" :"));
  return config.has(key) ? config.where(key) : config.file().string();
}

}  // namespace

const OutputPoint* OutputOptions::point(std::string_view name) const {
  const auto place = std::find_if(points.begin(), points.end(), [&](const OutputPoint& p) { return p.name == name; });
  return place == points.end() ? nullptr : &*place;
}

bool ReplayConfig::needs_history() const {
  return !output.points.empty() || output.covariance || output.columns.needs_log() || !events.empty();
}

ReplayConfig read_replay_config(const std::filesystem::path& file) { return read_replay_config(Config::load(file)); }

ReplayConfig read_replay_config(const Config& config) {
  ReplayConfig replay;
  replay.file = config.file();
  replay.echo = config.source();
  FilterOptions& filter = replay.filter;
  read_imus(config, replay);
  for (const Config& source : config.maps("gnss")) {
    const LogFile log = read_gnss_file(source);
    for (const LogFile& other : replay.gnss) refuse_repeated(source, log, other);
    replay.gnss.push_back(log);
    filter.gnss.push_back(read_gnss_options(source, replay.gnss.back()));
    if (filter.gnss.back().drift && filter.gnss.size() > kDriftingReceivers) {
      source.fail("drift", fmt::format("only the first {} receivers of the list may have one", kDriftingReceivers));
    }
    if (filter.gnss.back().lever_arm_sway && filter.gnss.size() > kDriftingReceivers) {
      source.fail("lever_arm_sway",
                  fmt::format("only the first {} receivers of the list may have one", kDriftingReceivers));
    }
  }
  for (const Config& source : config.maps("attitude")) {
    const LogFile log = read_attitude_file(source);
    for (const LogFile& other : replay.attitude) refuse_repeated(source, log, other);
    replay.attitude.push_back(log);
    filter.attitude.push_back(read_attitude_options(source, replay.attitude.back()));
  }
  filter.behaviour = read_behaviour(config);
  MagneticConditioning magnetic = read_magnetometer(config, filter);
  replay.initial = read_initial(config, filter, magnetic);
  filter.vehicle = read_vehicle(config);
  replay.odometer = read_odometer(config, filter);
  replay.barometer = read_barometer(config, filter);
  replay.heading = read_dual_heading(config, filter);
  filter.estimate = read_estimate(config, filter);
  filter.priors = read_priors(config);
  filter.adapt = read_adaptation(config);
  replay.smoother = read_smoother(config);
  replay.batch = read_batch(config, replay.smoother);
  if (replay.smoother == SmootherKind::kBatch &&
      std::ranges::any_of(replay.filter.gnss, [](const GnssOptions& g) { return g.velocity_averaging > 0; }))
    config.fail("smoother", "the batch has no `velocity_averaging`; choose `rts`, or leave that key out");
  replay.rates = read_output(config);
  replay.output = read_output_options(config, replay.smoother);
  replay.events = read_events(config, replay.output, replay.smoother);
  replay.conditioning = {.imu = replay.imu.conditioning,
                         .imus = std::move(replay.conditioning.imus),
                         .magnetic = magnetic,
                         .gyro_range = replay.imu.sensor.gyro.range,
                         .accel_range = replay.imu.sensor.accel.range,
                         .span = read_span(config),
                         .outages = read_outages(config),
                         .behaviour = filter.behaviour};
  config.finish();
  if (replay.gnss.empty()) {
    throw ConfigError(config.where(),
                      "key `gnss` is missing; position needs a receiver, such as "
                      "`gnss: {file: gnss.csv, lever_arm: 0 0 -0.4 m}`");
  }
  try {
    filter.validate();
  } catch (const ConfigError& e) {
    throw ConfigError(where_of(config, e.what()), e.what());
  }
  return replay;
}

Recording read_recording(const ReplayConfig& config) {
  Recording recording;
  recording.imu = read_imu(config.imu);
  for (const ImuSource& imu : config.further) recording.further.push_back(read_imu(imu));
  for (const LogFile& log : config.gnss) recording.gnss.push_back(read_gnss(log));
  check_velocities(recording.gnss, config.filter);
  for (const LogFile& log : config.attitude) recording.attitude.push_back(read_attitude(log));
  const FilterOptions& filter = config.filter;
  if (config.odometer) {
    recording.speed = read_speed(*config.odometer, filter.odometer->sigma, filter.odometer->is_signed);
  }
  if (config.barometer) recording.height = read_height(*config.barometer, filter.barometer->sigma);
  if (config.heading) recording.heading = read_heading(*config.heading, filter.heading->sigma);
  return recording;
}

}  // namespace piste
