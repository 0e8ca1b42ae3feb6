#include "piste/start/attitude_noise.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <vector>

#include "piste/core/state_table.h"
#include "piste/math/statistics.h"
#include "start/mounting.h"
#include "start/stretch.h"
#include "walker/own_times.h"

namespace piste {
namespace {

constexpr double kLongestLapse =
    1.1;                          // s between fixes: beyond it, gyroscopes and slow errors outweigh the white noise
constexpr double kFastest = 0.1;  // rad/s
constexpr double kOutlier = 6;    // times the median
constexpr std::size_t kFewestPairs = 200;  // pairs of steps
constexpr double kLeast = 0.1, kMostDrift = 0.995;

// For each pair of successive fixes: the rotation of the reference less that of the gyroscopes, in w. Nothing for a
// pair that must not be used.
std::vector<std::optional<Vector3d>> differences(const Log& log, const std::vector<AttitudeFix>& fixes,
                                                 const Mounting& mounting) {
  std::vector<std::optional<Vector3d>> out;
  const auto spoilt = [](const ImuSample& s) { return s.gap || s.clipped_gyro != 0; };
  for (std::size_t k = 0; k + 1 < fixes.size(); ++k) {
    const AttitudeFix &from = fixes[k], &to = fixes[k + 1];
    const double lapse = to.time - from.time;
    out.emplace_back();
    const auto samples = range(log.imu, from.time, to.time + log.imu.front().interval);
    if (lapse > kLongestLapse || std::any_of(samples.begin(), samples.end(), spoilt)) continue;
    const Vector3d b = so3_log(turned(log, from.time, to.time, mounting.gyro_bias));
    if (b.norm() > kFastest * lapse) continue;
    const Vector3d r = so3_log(from.q_wr.conjugate() * so3_exp(lapse * log.world.earth_rate()) * to.q_wr);
    out.back() = from.q_wr * (r - mounting.q_rb * b);
  }
  return out;
}

// Removes differences that are far larger than the median.
void drop_outliers(std::vector<std::optional<Vector3d>>& steps) {
  std::vector<double> sizes;
  for (const auto& step : steps) {
    if (step) sizes.push_back(step->norm());
  }
  if (sizes.empty()) return;
  const double limit = kOutlier * median(std::move(sizes));
  for (auto& step : steps) {
    if (step && step->norm() > limit) step.reset();
  }
}

// The delay of a reference, near the configured one, for which its rotations agree best with those of the gyroscopes
// (least squares). An error of 20 ms in the delay would pass for white noise.
double agreeing_delay(const Log& log, const std::vector<AttitudeFix>& fixes, AttitudeOptions source, double prior,
                      const Mounting& mounting) {
  const auto misfit = [&](double delay) {
    source.delay = delay;
    auto steps = differences(log, at_own_times(fixes, source), mounting);
    drop_outliers(steps);
    double sum = 0, count = 0;
    for (const auto& step : steps) {
      if (!step) continue;
      sum += step->squaredNorm();
      ++count;
    }
    return sum / std::max(1.0, count);
  };
  // The best of a grid over ± three sigmas, then the vertex of the parabola through it and its neighbours, twice.
  constexpr int kHalfGrid = 9;
  const double configured = source.delay, step = 3 * prior / kHalfGrid;
  double best = configured, least = misfit(configured);
  for (int k = -kHalfGrid; k <= kHalfGrid; ++k) {
    const double at = configured + k * step, value = misfit(at);
    if (value < least) {
      least = value;
      best = at;
    }
  }
  for (const double apart : {step, step / 8}) {
    const double before = misfit(best - apart), here = misfit(best), after = misfit(best + apart);
    const double bend = before - 2 * here + after;
    if (bend > 0) best += std::clamp(0.5 * (before - after) / bend, -1.0, 1.0) * apart;
  }
  return best;
}

// Turns each difference from w to the local level at the first fix of a receiver at or after it.
void turn_to_level(std::vector<std::optional<Vector3d>>& steps, const Log& log, const std::vector<AttitudeFix>& fixes) {
  const auto receiver = std::find_if(log.gnss.begin(), log.gnss.end(), [](const auto& g) { return !g.empty(); });
  if (receiver == log.gnss.end()) return;
  for (std::size_t k = 0; k < steps.size(); ++k) {
    if (!steps[k]) continue;
    const auto after = first_at_or_after(*receiver, fixes[k].time);
    const GnssFix& place = after == receiver->end() ? receiver->back() : *after;
    *steps[k] = (log.world.rotation_wn(place.position).transpose() * *steps[k]).eval();
  }
}

// Variance of the white error in the local level; nothing if there are too few pairs.
std::optional<Vector3d> white_variance(const std::vector<std::optional<Vector3d>>& steps) {
  Vector3d sum = Vector3d::Zero();
  std::size_t count = 0;
  for (std::size_t k = 0; k + 1 < steps.size(); ++k) {
    if (!steps[k] || !steps[k + 1]) continue;
    sum -= steps[k]->cwiseProduct(*steps[k + 1]);
    ++count;
  }
  if (count < kFewestPairs) return std::nullopt;
  return sum / static_cast<double>(count);
}

// Estimates in turn the delays that agree best, and the mounting: each of the two is needed for the other.
void find_delays_and_mounting(const Log& log, const FilterOptions& options, std::vector<AttitudeOptions>& sources,
                              std::optional<Mounting>& mounting) {
  constexpr int kRounds = 2;
  for (int round = 0; mounting && round < kRounds; ++round) {
    for (std::size_t i = 0; i < sources.size(); ++i) {
      sources[i].delay = agreeing_delay(log, log.attitude[i], sources[i], options.priors.attitude_delay, *mounting);
    }
    mounting = find_mounting(log, sources);
  }
}

}  // namespace

FilterOptions with_attitude_sigmas(FilterOptions options, const std::vector<AttitudeRecording>& attitude) {
  for (std::size_t i = 0; i < options.attitude.size(); ++i) {
    if (!options.attitude[i].drift) continue;
    Vector3d sum = Vector3d::Zero();
    for (const EulerFix& fix : attitude[i].fixes) sum += fix.sigma.cwiseAbs2();
    const Vector3d mean = sum / static_cast<double>(attitude[i].fixes.size());
    const double level = std::sqrt((mean.x() + mean.y()) / 2);
    options.attitude[i].drift->sigma = {level, level, std::sqrt(mean.z())};
  }
  return options;
}

FilterOptions with_white_part(FilterOptions options, const Log& log) {
  std::vector<AttitudeOptions> on_time = options.attitude;
  std::optional<Mounting> mounting = find_mounting(log, on_time);
  if (StateLayout(options.estimate).has(Block::kAttitudeDelay)) {
    find_delays_and_mounting(log, options, on_time, mounting);
  }
  for (std::size_t i = 0; i < options.attitude.size(); ++i) {
    AttitudeOptions& source = options.attitude[i];
    if (!source.drift || !mounting) continue;
    const std::vector<AttitudeFix> fixes = at_own_times(log.attitude[i], on_time[i]);
    auto steps = differences(log, fixes, *mounting);
    drop_outliers(steps);
    turn_to_level(steps, log, fixes);
    const std::optional<Vector3d> variance = white_variance(steps);
    if (!variance) continue;
    const Vector3d total = source.drift->sigma.cwiseAbs2();
    const double level = (variance->x() + variance->y()) / (total.x() + total.y()),
                 vertical = variance->z() / total.z();
    const Vector3d part = Vector3d(level, level, vertical).cwiseMax(kLeast * kLeast).cwiseMin(1);
    source.white = part.cwiseSqrt();
    source.drift->sigma = source.drift->sigma.cwiseProduct((1 - kMostDrift * part.array()).sqrt().matrix());
  }
  return options;
}

}  // namespace piste
