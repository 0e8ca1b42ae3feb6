#include "piste/allan/sensor_noise.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <numbers>
#include <tuple>

#include "io/triad_units.h"
#include "piste/math/statistics.h"

namespace piste {
namespace {

using Kind = ProcessKind;

// Deviation of flicker noise of unit size: √(2 ln 2 / π).
const double kFlickerDeviation = std::sqrt(2 * std::numbers::ln2 / std::numbers::pi);

bool is_fast(const NoiseProcess& p) {
  return p.kind == Kind::kWhite || p.kind == Kind::kQuantisation ||
         (p.kind == Kind::kGaussMarkov && p.correlation_time < kFastTime);
}

double fast_density(std::span<const NoiseProcess> processes) {
  double square_sum = 0;
  for (const NoiseProcess& p : processes) {
    if (!is_fast(p)) continue;
    const double factor = p.kind == Kind::kWhite          ? 1
                          : p.kind == Kind::kQuantisation ? 3 / kFastTime
                                                          : 2 * p.correlation_time;
    square_sum += factor * square(p.size);
  }
  return std::sqrt(square_sum);
}

// A function of the model with its interval, by the first derivatives of its logarithm.
Measured derived(const GmwmFit& fit, double probability,
                 const std::function<double(std::span<const NoiseProcess>)>& of) {
  constexpr double kStep = 1e-3;
  const std::vector<NoiseProcess> model = fit.processes();
  Measured m;
  m.value = of(model);
  if (!(m.value > 0)) return m;
  Eigen::VectorXd slope(fit.logs.rows());
  Eigen::Index at = 0;
  const auto differentiate = [&](std::size_t i, double NoiseProcess::*number) {
    std::vector<NoiseProcess> more = model, less = model;
    more[i].*number *= std::exp(kStep);
    less[i].*number *= std::exp(-kStep);
    slope(at++) = (std::log(of(more)) - std::log(of(less))) / (2 * kStep);
  };
  for (std::size_t i = 0; i < model.size(); ++i) {
    differentiate(i, &NoiseProcess::size);
    if (model[i].kind == Kind::kGaussMarkov) differentiate(i, &NoiseProcess::correlation_time);
  }
  m.sigma_log = std::sqrt(std::max(0.0, slope.dot(fit.logs * slope)));
  std::tie(m.low, m.high) = size_interval(m.value, m.sigma_log, probability);
  return m;
}

// The logarithm of a factor, and its 1-sigma.
struct LogFactor {
  double value = 0, sigma = 0;
};

// The factor between the deviation of a curve and that of its model, at the scales of kFastTime and more that fast
// noise dominates. A sum of processes cannot fall faster than white noise first and like it later, as the curve of a
// dithered gyroscope does: its misfit at short scales appears at these. Its sigma is that of a curve of the model
// itself.
LogFactor off_where_fast(const GmwmFit& fit, const AllanCurve& curve) {
  constexpr double kShare = 0.9;
  std::vector<NoiseProcess> fast;
  for (const NoiseProcess& p : fit.processes()) {
    if (is_fast(p)) fast.push_back(p);
  }
  LogFactor off;
  Eigen::VectorXd slope = Eigen::VectorXd::Zero(fit.covariance.rows());  // of the mean logarithm, by each variance
  double weights = 0;
  for (std::size_t i = 0; i < fit.variance.size(); ++i) {
    if (curve.tau(i) < kFastTime) continue;
    if (allan_variance(fast, curve.scales[i].samples, curve.interval) < kShare * fit.variance[i]) continue;
    const auto row = static_cast<Eigen::Index>(i);
    const double weight = square(fit.variance[i]) / fit.covariance(row, row);
    off.value += weight * std::log(fit.measured[i] / fit.variance[i]);
    slope(row) = weight / fit.variance[i];
    weights += weight;
  }
  if (!(weights > 0)) return {};
  off.value /= 2 * weights;
  off.sigma = std::sqrt(slope.dot(fit.covariance * slope)) / (2 * weights);
  return off;
}

constexpr std::size_t kAround = 64;  // samples about which an outlier is judged

// Calls act(place, median) for each outlying value.
template <class Act>
void for_each_outlying(std::span<const double> values, double sigmas, const Act& act) {
  if (values.size() < kAround) return;
  const std::size_t blocks = values.size() / kAround;
  std::vector<double> medians(blocks), spreads(blocks), part;
  const auto end_of = [&](std::size_t b) { return b + 1 == blocks ? values.size() : (b + 1) * kAround; };
  for (std::size_t b = 0; b < blocks; ++b) {
    part.assign(values.begin() + static_cast<std::ptrdiff_t>(b * kAround),
                values.begin() + static_cast<std::ptrdiff_t>(end_of(b)));
    medians[b] = median(part);
    for (double& v : part) v = std::abs(v - medians[b]);
    spreads[b] = median(part);
  }
  double spread = kSigmaOverMedian * median(spreads);
  // Values rounded so coarsely that most are equal: the step is their variation.
  if (spread == 0) spread = value_step(values);
  if (spread == 0) return;
  for (std::size_t b = 0; b < blocks; ++b) {
    for (std::size_t i = b * kAround; i < end_of(b); ++i) {
      if (std::abs(values[i] - medians[b]) > sigmas * spread) act(i, medians[b]);
    }
  }
}

// Octaves of τ from `shortest` to `longest`.
std::vector<double> octaves(double shortest, double longest) {
  std::vector<double> taus;
  for (double t = shortest; t <= longest * 1.001; t *= 2) taus.push_back(t);
  return taus;
}

// Variance of processes of samples that are far shorter than τ and than any correlation time.
double variance_at(std::span<const NoiseProcess> processes, double tau) {
  constexpr double kFewest = 256;
  double sum = 0;
  for (const NoiseProcess& p : processes) {
    const double samples = std::max(kFewest, p.correlation_time > 0 ? kFewest * tau / p.correlation_time : 0);
    sum += allan_variance(p, static_cast<std::size_t>(samples), tau / std::floor(samples));
  }
  return sum;
}

}  // namespace

ProcessUnit unit_of(ProcessKind kind, bool gyro) {
  const TriadUnits& units = gyro ? kGyroUnits : kAccelUnits;
  const double value = unit_factor(units.value_unit, units.value);
  const std::string name(units.value_unit);
  switch (kind) {
    case ProcessKind::kQuantisation:
      return {gyro ? "deg" : "m/s", value};
    case ProcessKind::kWhite:
      return {std::string(units.noise_unit), unit_factor(units.noise_unit, units.noise)};
    case ProcessKind::kRandomWalk:
      return {std::string(units.drift_unit), unit_factor(units.drift_unit, units.drift)};
    case ProcessKind::kRamp:
      return {gyro ? "deg/s^2" : "m/s^3", value};
    case ProcessKind::kBiasInstability:
    case ProcessKind::kGaussMarkov:
      break;
  }
  return {name, value};
}

AxisNoise axis_noise(const GmwmFit& fit, const AllanCurve& curve, double probability) {
  AxisNoise axis;
  axis.noise = derived(fit, probability, fast_density);
  if (fit.model_error > 0) {
    constexpr double kBeyondChance = 3;  // sigmas: of one curve in twenty chance makes a model error
    const LogFactor off = off_where_fast(fit, curve);
    if (std::abs(off.value) > kBeyondChance * off.sigma) {
      Measured& noise = axis.noise;
      noise.value *= std::exp(off.value);
      noise.sigma_log = std::hypot(noise.sigma_log, off.sigma);
      std::tie(noise.low, noise.high) = size_interval(noise.value, noise.sigma_log, probability);
    }
  }
  const std::vector<NoiseProcess> model = fit.processes();
  std::size_t lowest = 0;
  for (std::size_t i = 0; i < fit.variance.size(); ++i) {
    if (fit.variance[i] < fit.variance[lowest]) lowest = i;
  }
  axis.instability_tau = curve.tau(lowest);
  axis.lowest_inside = lowest + 1 < fit.variance.size();
  if (const FittedProcess* flicker = fit.find(Kind::kBiasInstability)) {
    axis.flicker = true;
    axis.instability = {flicker->process.size, flicker->low, flicker->high, flicker->sigma_log};
  } else {
    const std::size_t m = curve.scales[lowest].samples;
    axis.instability = derived(fit, probability, [&](std::span<const NoiseProcess> processes) {
      return std::sqrt(allan_variance(processes, m, curve.interval)) / kFlickerDeviation;
    });
  }
  for (const NoiseProcess& p : model) {
    if (!is_fast(p)) axis.drift.push_back(p);
  }
  return axis;
}

double value_step(std::span<const double> values) {
  constexpr std::size_t kLooked = 50'000, kFewest = 32;
  constexpr double kRepeats = 4;       // least mean number of equal values: with fewer they are not rounded
  constexpr double kTolerance = 0.02;  // of a step: factors of units are rounded as well
  std::vector<double> seen(values.begin(),
                           values.begin() + static_cast<std::ptrdiff_t>(std::min(values.size(), kLooked)));
  if (seen.size() < kFewest) return 0;
  std::sort(seen.begin(), seen.end());
  const double close = 1e-9 * std::max(std::abs(seen.front()), std::abs(seen.back()));
  std::vector<double> distinct;
  for (const double v : seen) {
    if (distinct.empty() || v - distinct.back() > close) distinct.push_back(v);
  }
  if (distinct.size() < 2 || kRepeats * static_cast<double>(distinct.size()) > static_cast<double>(seen.size()))
    return 0;
  double step = std::numeric_limits<double>::infinity();
  for (std::size_t i = 1; i < distinct.size(); ++i) step = std::min(step, distinct[i] - distinct[i - 1]);
  // The smallest distance is the step if all others are multiples of it; the mean over all of them is more exact.
  double steps = 0;
  for (std::size_t i = 1; i < distinct.size(); ++i) {
    const double apart = (distinct[i] - distinct[i - 1]) / step;
    if (std::abs(apart - std::round(apart)) > kTolerance * std::max(1.0, apart)) return 0;
    steps += std::round(apart);
  }
  return (distinct.back() - distinct.front()) / steps;
}

double rounding_noise(double step, double interval) { return step * std::sqrt(interval / 12); }

std::vector<std::size_t> outlying(std::span<const double> values, double sigmas) {
  std::vector<std::size_t> places;
  for_each_outlying(values, sigmas, [&](std::size_t i, double) { places.push_back(i); });
  return places;
}

std::size_t replace_outlying(std::vector<double>& values, double sigmas) {
  std::vector<std::pair<std::size_t, double>> replaced;
  for_each_outlying(values, sigmas, [&](std::size_t i, double with) { replaced.emplace_back(i, with); });
  for (const auto& [i, with] : replaced) values[i] = with;
  return replaced.size();
}

NearestDrift nearest_drift(std::span<const AxisNoise> axes, double shortest, double longest) {
  NearestDrift nearest;
  std::vector<NoiseProcess> all;
  for (const AxisNoise& axis : axes) all.insert(all.end(), axis.drift.begin(), axis.drift.end());
  const auto count = static_cast<double>(axes.size());
  const std::vector<double> taus = octaves(std::max(shortest, kFastTime), longest);
  if (all.empty() || taus.empty()) {
    nearest.why = "no drift was seen";
    return nearest;
  }
  std::vector<double> drift, weight;
  for (const double tau : taus) {
    double white = 0;
    for (const AxisNoise& axis : axes) white += square(axis.noise.value) / tau / count;
    drift.push_back(variance_at(all, tau) / count);
    weight.push_back(drift.back() / (drift.back() + white));
  }
  // The size that is nearest for a shape, and how near.
  struct Near {
    double size = 0, cost = std::numeric_limits<double>::infinity();
    NoiseProcess process;
  };
  const auto try_shape = [&](NoiseProcess p) {
    p.size = 1;
    double sum = 0, weights = 0;
    std::vector<double> ratio;
    for (std::size_t i = 0; i < taus.size(); ++i) {
      ratio.push_back(std::log(drift[i] / variance_at({&p, 1}, taus[i])));
      sum += square(weight[i]) * ratio.back();
      weights += square(weight[i]);
    }
    Near near;
    near.cost = 0;
    for (std::size_t i = 0; i < taus.size(); ++i) near.cost += square(weight[i] * (ratio[i] - sum / weights));
    p.size = std::exp(sum / weights / 2);
    near.process = p;
    return near;
  };
  Near best = try_shape({Kind::kRandomWalk, 1, 0});
  constexpr double kWorthATime = 0.8;  // a correlation time is one more parameter: it must lower the cost so far
  best.cost *= kWorthATime;
  constexpr int kTimes = 200;
  for (int i = 0; i <= kTimes; ++i) {
    const double time = kFastTime * std::pow(longest / kFastTime, static_cast<double>(i) / kTimes);
    if (const Near near = try_shape({Kind::kGaussMarkov, 1, time}); near.cost < best.cost) best = near;
  }
  const bool one_kind =
      std::all_of(all.begin(), all.end(), [&](const NoiseProcess& p) { return p.kind == all[0].kind; });
  const bool whole = one_kind && all.size() <= axes.size();
  if (best.process.kind == Kind::kRandomWalk) {
    nearest.process = {DriftProcess::Kind::kRandomWalk, 0, 0, best.process.size};
    nearest.why = whole && all[0].kind == Kind::kRandomWalk ? "the random walk of the model"
                                                            : "the random walk nearest to the drift of the model";
  } else {
    nearest.process = {DriftProcess::Kind::kGaussMarkov, best.process.size, best.process.correlation_time, 0};
    nearest.why = whole && all[0].kind == Kind::kGaussMarkov
                      ? "the Gauss-Markov process of the model"
                      : "the Gauss-Markov process nearest to the drift of the model";
  }
  constexpr double kMatters = 0.2;
  for (std::size_t i = 0; i < taus.size(); ++i) {
    if (weight[i] < kMatters) continue;
    nearest.off = std::max(nearest.off, std::abs(std::sqrt(variance_at({&best.process, 1}, taus[i]) / drift[i]) - 1));
  }
  return nearest;
}

double equal_p_value(std::span<const Measured> values) {
  double weights = 0, sum = 0;
  for (const Measured& m : values) {
    const double w = 1 / square(m.sigma_log);
    weights += w;
    sum += w * std::log(m.value);
  }
  double squares = 0;
  for (const Measured& m : values) squares += square((std::log(m.value) - sum / weights) / m.sigma_log);
  if (values.size() < 2 || !std::isfinite(squares)) return 1;
  return chi_squared_above(squares, static_cast<double>(values.size() - 1));
}

double spread_between(std::span<const Measured> values) {
  if (values.size() < 2) return kNaN;
  std::vector<double> logs;
  double own = 0;
  for (const Measured& m : values) {
    logs.push_back(std::log(m.value));
    own += square(m.sigma_log) / static_cast<double>(values.size());
  }
  return std::sqrt(std::max(0.0, square(standard_deviation(logs)) - own));
}

}  // namespace piste
