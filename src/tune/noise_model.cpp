#include "tune/noise_model.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/recording.h"
#include "io/triad_units.h"
#include "piste/core/state_table.h"
#include "piste/math/statistics.h"
#include "piste/math/units.h"

namespace piste {
namespace {

constexpr double kLeastWhite = 0.1;     // of the whole error, as model/gnss.h has it where a drift is in m
constexpr double kMostShare = 0.99999;  // as configurations have five digits

// By how much a coloured error of heights that stand still is larger than that of their rounding, where a receiver's
// errors do not last as long: means over some time are to be as wrong, and single heights not unknown.
constexpr double kMostSlow = 3;

// Intervals between fixes that the correlation time of their errors has at least: what is shorter and white noise are
// distinguished by how the body moves between two fixes alone, so that a vibrating IMU would get the blame.
constexpr double kFixesCorrelated = 5;
constexpr double kUnlimited = std::numeric_limits<double>::infinity();

class KnobList {
 public:
  std::vector<NoiseKnob> knobs;

  void add(std::string name, std::string_view unit, double factor, double width, std::function<double&(NoiseModel&)> at,
           double most = kUnlimited, double least = 0) {
    knobs.push_back({std::move(name), std::string(unit), factor, width, most, std::move(at), least});
  }

  // White noise and drift of the triad `of`; the drift if it is estimated.
  void add_triad(const std::string& name, TriadErrors ImuSensor::*of, const DriftProcess& drift, bool estimated,
                 const TriadUnits& units, double least, double most) {
    using Kind = DriftProcess::Kind;
    const auto process = [of](NoiseModel& m) -> DriftProcess& { return (m.sensor.*of).drift; };
    add(
        name + ".noise", units.noise_unit, 1 / unit_factor(units.noise_unit, units.noise), kSizeWidth,
        [of](NoiseModel& m) -> double& { return (m.sensor.*of).noise; }, most, least);
    if (!estimated) return;
    if (drift.kind == Kind::kRandomWalk) {
      add(name + ".drift.density", units.drift_unit, 1 / unit_factor(units.drift_unit, units.drift), kSizeWidth,
          [process](NoiseModel& m) -> double& { return process(m).density; });
    } else if (drift.kind == Kind::kGaussMarkov) {
      add(name + ".drift.sigma", units.value_unit, 1 / unit_factor(units.value_unit, units.value), kSizeWidth,
          [process](NoiseModel& m) -> double& { return process(m).sigma; });
      add(name + ".drift.correlation_time", "s", 1, kTimeWidth,
          [process](NoiseModel& m) -> double& { return process(m).correlation_time; });
    }
  }
};

// Median of the times between fixes [s].
double median_interval(const std::vector<GnssFix>& fixes) {
  std::vector<double> intervals;
  intervals.reserve(fixes.size());
  for (std::size_t k = 1; k < fixes.size(); ++k) intervals.push_back(fixes[k].time - fixes[k - 1].time);
  return intervals.empty() ? 0 : median(std::move(intervals));
}

// Median of the sigmas of positions, north, east, down.
Vector3d median_sigma(const std::vector<GnssFix>& fixes) {
  Vector3d result = Vector3d::Ones();
  for (int axis = 0; axis < 3 && !fixes.empty(); ++axis) {
    std::vector<double> sigmas;
    sigmas.reserve(fixes.size());
    for (const GnssFix& fix : fixes) sigmas.push_back(fix.sigma_position(axis));
    result(axis) = median(std::move(sigmas));
  }
  return result;
}

bool any_velocity(const std::vector<GnssFix>& fixes) {
  return std::any_of(fixes.begin(), fixes.end(), [](const GnssFix& fix) { return fix.velocity.has_value(); });
}

}  // namespace

double ReceiverNoise::position() const {
  const double part =
      in_metres ? drift_shape.norm() / stated.norm() : drift_shape.head<2>().norm() / stated.head<2>().norm();
  return std::hypot(white, drift * part);
}

Vector3d ReceiverNoise::slow() const {
  if (!(drift > 0)) return standing.slow > 0 ? standing.process().sigma : Vector3d::Zero();
  Vector3d sigma = drift * Vector3d(drift_shape.x(), drift_shape.y(), height * drift_shape.z());
  // Larger where it does not last as long, so that means over some time are as wrong.
  const double longer = std::clamp(std::sqrt(kStandingTime / drift_time), 1.0, kMostSlow);
  sigma.z() = std::max(sigma.z(), longer * standing.slow);
  return sigma;
}

SigmaScales ReceiverNoise::scales() const {
  SigmaScales factors{.position = position(), .height = height, .velocity = velocity};
  if (standing.slow > 0 || (drift > 0 && !in_metres)) {
    const double single = std::max(height * white * stated.z(), standing.white);
    factors.height = std::hypot(single, slow().z()) / (position() * stated.z());
  }
  return factors;
}

std::optional<PositionDrift> ReceiverNoise::process() const {
  const Vector3d sigma = slow();
  if (sigma.isZero(0)) return std::nullopt;
  if (!(drift > 0)) return PositionDrift(standing.process());
  if (in_metres) return PositionDrift({sigma, drift_time});
  const SigmaScales total = scales();
  const Vector3d whole = total.position * Vector3d(stated.x(), stated.y(), total.height * stated.z());
  PositionDrift share = PositionDrift::of_share(sigma.cwiseQuotient(whole).cwiseMin(kMostShare), drift_time);
  share.most_white = most_white;
  return share;
}

NoiseModel noise_model(const FilterOptions& options, const Log& log) {
  NoiseModel model{.sensor = options.sensor, .gnss = {}, .attitude_time = {}};
  for (std::size_t i = 0; i < options.gnss.size(); ++i) {
    ReceiverNoise& receiver = model.gnss.emplace_back();
    receiver.stated = receiver.drift_shape = median_sigma(log.gnss[i]);
    receiver.drift_time = kSlowTime;
    receiver.is_white = options.gnss[i].white;
    const auto& drift = options.gnss[i].drift;
    if (drift && is_of_heights_alone(*drift)) {
      receiver.standing = standing_heights(log.gnss[i], log.world);
    } else if (drift) {
      receiver.drift = 1;
      receiver.drift_time = drift->correlation_time;
      receiver.in_metres = !drift->of_stated;
      receiver.drift_shape = drift->sigma_at(receiver.stated);
      if (receiver.in_metres) {
        const double part = drift->sigma.norm() / receiver.stated.norm();
        receiver.white = std::sqrt(std::max(1 - part * part, kLeastWhite * kLeastWhite));
      } else {
        receiver.most_white = drift->most_white;
        const auto rest = [](double share) { return std::sqrt(1 - share * share); };
        receiver.white = rest(drift->sigma.head<2>().mean());
        receiver.height = rest(drift->sigma.z()) / receiver.white;
        receiver.drift_shape.z() /= receiver.height;
      }
    }
  }
  for (const AttitudeOptions& source : options.attitude)
    model.attitude_time.push_back(source.drift ? source.drift->correlation_time : 0);
  return model;
}

std::vector<NoiseKnob> knobs_of(const NoiseModel& model, const FilterOptions& options, const Log& log,
                                const WhiteNoiseRange& white) {
  const StateLayout layout(options.estimate);
  KnobList list;
  list.add_triad("gyro", &ImuSensor::gyro, model.sensor.gyro.drift, layout.has(Block::kGyroDrift), kGyroUnits,
                 white.least.gyro, white.most.gyro);
  list.add_triad("accel", &ImuSensor::accel, model.sensor.accel.drift, layout.has(Block::kAccelDrift), kAccelUnits,
                 white.least.accel, white.most.accel);
  for (std::size_t i = 0; i < model.gnss.size(); ++i) {
    if (log.gnss[i].empty()) continue;
    const std::string name = fmt::format("gnss[{}].", i);
    const GnssOptions& receiver = options.gnss[i];
    const bool coloured = model.gnss[i].drift > 0;
    if (receiver.use_position) {
      list.add(name + (coloured ? "white_scale" : "sigma_scale"), "", 1, kSizeWidth,
               [i](NoiseModel& m) -> double& { return m.gnss[i].white; });
    }
    if (receiver.use_position && model.gnss[i].height != 1) {
      list.add(name + "sigma_height_scale", "", 1, kSizeWidth,
               [i](NoiseModel& m) -> double& { return m.gnss[i].height; });
    }
    if (receiver.use_velocity && any_velocity(log.gnss[i])) {
      list.add(name + "sigma_velocity_scale", "", 1, kSizeWidth,
               [i](NoiseModel& m) -> double& { return m.gnss[i].velocity; });
    }
    if (!coloured || !receiver.use_position) continue;
    if (std::isfinite(model.gnss[i].most_white)) {
      list.add(name + "drift.most_white", "m", 1, kSizeWidth,
               [i](NoiseModel& m) -> double& { return m.gnss[i].most_white; });
    }
    list.add(name + "drift.sigma", "m", model.gnss[i].drift_shape.x(), kSizeWidth,
             [i](NoiseModel& m) -> double& { return m.gnss[i].drift; });
    list.add(
        name + "drift.correlation_time", "s", 1, kTimeWidth,
        [i](NoiseModel& m) -> double& { return m.gnss[i].drift_time; }, kUnlimited,
        kFixesCorrelated* median_interval(log.gnss[i]));
  }
  for (std::size_t i = 0; i < model.attitude_time.size(); ++i) {
    if (model.attitude_time[i] == 0) continue;
    list.add(fmt::format("attitude[{}].correlation_time", i), "s", 1, kTimeWidth,
             [i](NoiseModel& m) -> double& { return m.attitude_time[i]; });
  }
  return std::move(list.knobs);
}

FilterOptions with_noise(FilterOptions options, const NoiseModel& model) {
  options.sensor = model.sensor;
  for (std::size_t i = 0; i < model.gnss.size(); ++i) options.gnss[i].drift = model.gnss[i].process();
  for (std::size_t i = 0; i < model.attitude_time.size(); ++i) {
    if (options.attitude[i].drift) options.attitude[i].drift->correlation_time = model.attitude_time[i];
  }
  options.estimate = with_implied_blocks(options, options.estimate);
  return options;
}

Log with_noise(Log log, const NoiseModel& model) {
  for (std::size_t i = 0; i < model.gnss.size(); ++i) scale_sigmas(log.gnss[i], model.gnss[i].scales());
  return log;
}

}  // namespace piste
