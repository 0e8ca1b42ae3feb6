#include "piste/inspect/imu_health.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <tuple>
#include <utility>

#include "condition/spikes.h"
#include "core/row_gaps.h"
#include "imu_bounds.h"
#include "piste/math/earth.h"
#include "piste/math/statistics.h"
#include "piste/math/units.h"

namespace piste {
namespace {

constexpr double kNoiseWindow = 1, kShortestRest = 2;      // s
constexpr double kQuietest = 0.05;                         // share of the windows that define the quietness of rest
constexpr double kAsQuiet = 3;                             // up to this many times as noisy is still rest
constexpr double kGyroShake = 3 * kDegree, kShake = 0.3;   // rad/s and parts of g: a larger rms is no rest
constexpr double kTurning = 3 * kDegree;                   // rad/s, relative to the bias
constexpr double kFastestTurn = 60, kHardestKnock = 1000;  // rad/s, m/s²: no body exceeds these
constexpr std::size_t kAtLimit = 8;                        // samples
constexpr std::size_t kPile = 3;
constexpr std::size_t kFrozenRows = 20;
constexpr double kMostForces = 0.95, kLeastForces = 0.2, kGravityRange = 4;

using Values = std::vector<Vector3d>;

// Rates of the rows. Increments are divided by their intervals, without the first row.
Values rates_of(const ImuRecording& imu, const Values& values) {
  if (!imu.increments) return values;
  Values rates;
  rates.reserve(values.size());
  for (std::size_t i = 0; i < values.size(); ++i) {
    const std::size_t later = std::max<std::size_t>(i, 1);
    rates.emplace_back(values[i] / (imu.time[later] - imu.time[later - 1]));
  }
  return rates;
}

std::vector<double> norms_of(const Values& values) {
  std::vector<double> norms(values.size());
  std::transform(values.begin(), values.end(), norms.begin(), [](const Vector3d& v) { return v.norm(); });
  return norms;
}

// The unit of the forces, from the magnitude of gravity.
std::optional<ImuHealth::WrongUnit> wrong_unit(double force, double interval, bool increments) {
  const double g = kStandardGravity;
  std::vector<ImuHealth::WrongUnit> wrong{{LogFault::kAccelG, 1 / g}, {LogFault::kAccelMetres, g}};
  if (increments) {
    wrong.push_back({LogFault::kRatesForIncrements, 1 / interval});
  } else {
    wrong.push_back({LogFault::kIncrementsForRates, interval});
    wrong.push_back({LogFault::kAccelG, 1e3 / g});  // thousandths of g
    wrong.push_back({LogFault::kAccelG, 1e3});      // the same, labelled as g
  }
  const auto distance = [&](double factor) { return std::abs(std::log(force / (g * factor))); };
  const auto best = std::min_element(wrong.begin(), wrong.end(), [&](const auto& a, const auto& b) {
    return distance(a.factor) < distance(b.factor);
  });
  // As labelled it is right: another unit is too near to that to differ, as increments over a second are.
  if (distance(1) <= std::log(kGravityTolerance)) return std::nullopt;
  if (distance(best->factor) > std::log(kGravityTolerance)) return std::nullopt;
  return *best;
}

struct Window {
  std::size_t begin, end;
  double gyro, accel;  // root-mean-square deviations
  Vector3d mean_gyro;
};

double deviation(const Values& values, std::size_t begin, std::size_t end, Vector3d& mean) {
  mean.setZero();
  double square = 0;
  for (std::size_t i = begin; i < end; ++i) mean += values[i];
  mean /= static_cast<double>(end - begin);
  for (std::size_t i = begin; i < end; ++i) square += (values[i] - mean).squaredNorm();
  return std::sqrt(square / static_cast<double>(end - begin));
}

// Joined windows in which the IMU is nearly as quiet as in its quietest ones. The units may be wrong, so forces are
// measured in parts of gravity.
std::vector<std::pair<std::size_t, std::size_t>> quiet_rows(const ImuRecording& imu, const Values& gyro,
                                                            const Values& accel, double gravity) {
  std::vector<Window> windows;
  for (std::size_t begin = 0, end = 0; begin < imu.time.size(); begin = end) {
    while (end < imu.time.size() && imu.time[end] - imu.time[begin] < kNoiseWindow) ++end;
    if (end - begin < 5) continue;
    Window w{begin, end, 0, 0, {}};
    Vector3d mean_accel;
    w.gyro = deviation(gyro, begin, end, w.mean_gyro);
    w.accel = deviation(accel, begin, end, mean_accel) / gravity;
    windows.push_back(w);
  }
  if (windows.empty()) return {};
  const auto all = [&](double Window::*of) {
    std::vector<double> v;
    v.reserve(windows.size());
    for (const Window& w : windows) v.push_back(w.*of);
    return v;
  };
  const double gyro_limit = std::min(kAsQuiet * quantile(all(&Window::gyro), kQuietest), kGyroShake);
  const double accel_limit = std::min(kAsQuiet * quantile(all(&Window::accel), kQuietest), kShake);
  std::erase_if(windows, [&](const Window& w) { return w.gyro > gyro_limit || w.accel > accel_limit; });
  if (windows.empty()) return {};
  std::vector<Vector3d> means;
  means.reserve(windows.size());
  for (const Window& w : windows) means.push_back(w.mean_gyro);
  const Vector3d bias = median_by_axis(means);
  std::vector<std::pair<std::size_t, std::size_t>> joined;
  for (const Window& w : windows) {
    if ((w.mean_gyro - bias).norm() > kTurning) continue;
    if (!joined.empty() && joined.back().second == w.begin) {
      joined.back().second = w.end;
    } else {
      joined.emplace_back(w.begin, w.end);
    }
  }
  std::erase_if(joined, [&](const auto& rows) {
    return imu.time[rows.second - 1] - imu.time[rows.first] < kShortestRest - 0.1 * kNoiseWindow;
  });
  return joined;
}

// The parts of stretches of rows that are outside of these times, and long enough to be rest.
std::vector<std::pair<std::size_t, std::size_t>> without(const std::vector<std::pair<std::size_t, std::size_t>>& all,
                                                         const std::vector<double>& time,
                                                         const std::vector<Interval>& moving) {
  if (moving.empty()) return all;
  std::vector<std::pair<std::size_t, std::size_t>> left;
  const auto keep = [&](std::size_t begin, std::size_t end) {
    if (end > begin + 1 && time[end - 1] - time[begin] >= kShortestRest - 0.1 * kNoiseWindow)
      left.emplace_back(begin, end);
  };
  std::size_t next = 0;
  for (const auto& [begin, end] : all) {
    std::size_t from = begin;
    for (std::size_t i = begin; i < end; ++i) {
      while (next < moving.size() && moving[next].end < time[i]) ++next;
      if (next == moving.size() || !moving[next].contains(time[i])) continue;
      keep(from, i);
      from = i + 1;
    }
    keep(from, end);
  }
  return left;
}

// The limit that an axis reaches often and never exceeds, and the number of samples there. More samples have this value
// than the next value inside. The limit is enough quantization steps from zero not to be the rounded rate of a calm
// body.
std::pair<double, std::size_t> clipping(const Values& values, int axis, double quantum) {
  const auto [low, high] = std::minmax_element(
      values.begin(), values.end(), [axis](const Vector3d& a, const Vector3d& b) { return a(axis) < b(axis); });
  std::pair<double, std::size_t> found{0, 0};
  if ((*low)(axis) == (*high)(axis)) return found;
  for (const double sign : {-1.0, 1.0}) {
    const double limit = sign < 0 ? (*low)(axis) : (*high)(axis);
    if (std::abs(limit) < kFewestSteps * quantum) continue;
    double within = -sign * std::numeric_limits<double>::infinity();
    std::size_t at_limit = 0, at_within = 0;
    for (const Vector3d& v : values) {
      if (v(axis) == limit) {
        ++at_limit;
      } else if (v(axis) == within) {
        ++at_within;
      } else if (sign * v(axis) > sign * within) {
        within = v(axis);
        at_within = 1;
      }
    }
    if (at_limit >= kAtLimit && at_limit > kPile * at_within)
      found = {std::max(found.first, std::abs(limit)), found.second + at_limit};
  }
  return found;
}

double repeated(const Values& values, int axis) {
  double same = 0;
  for (std::size_t i = 1; i < values.size(); ++i) same += values[i](axis) == values[i - 1](axis) ? 1 : 0;
  return same / static_cast<double>(values.size());
}

// Values and changes that no motion of a body explains, if the units are right.
struct Impossible {
  double value;
  Abruptness change;
};

TriadHealth triad(const ImuRecording& imu, const Values& stored, const Values& rates, const Impossible& impossible,
                  const std::vector<std::pair<std::size_t, std::size_t>>& quiet, double interval) {
  TriadHealth t;
  t.smallest = t.largest = rates.front();
  for (std::size_t i = 0; i < rates.size(); ++i) {
    t.smallest = t.smallest.cwiseMin(rates[i]);
    t.largest = t.largest.cwiseMax(rates[i]);
    if (rates[i].cwiseAbs().maxCoeff() > impossible.value && t.spikes++ == 0) t.first_spike = imu.time[i];
  }
  const std::vector<Spike> spikes =
      find_spikes(imu.time, find_gaps(imu.time), stored, imu.increments ? interval : 1, impossible.change);
  t.isolated = spikes.size();
  if (!spikes.empty()) {
    const auto first = std::ranges::min_element(spikes, {}, &Spike::row);
    t.first_isolated = imu.time[first->row];
  }
  // White noise from the differences of neighbouring samples, which motion and drift hardly affect.
  Vector3d sum = Vector3d::Zero(), difference2 = Vector3d::Zero();
  double rows = 0, pairs = 0;
  for (const auto& [begin, end] : quiet) {
    for (std::size_t i = begin; i < end; ++i) sum += rates[i];
    for (std::size_t i = begin + 1; i < end; ++i) difference2 += (rates[i] - rates[i - 1]).cwiseAbs2();
    rows += static_cast<double>(end - begin);
    pairs += static_cast<double>(end - begin - 1);
  }
  t.mean = rows > 0 ? Vector3d(sum / rows) : Vector3d::Constant(kNaN);
  t.noise = pairs > 0 ? Vector3d((difference2 / (2 * pairs) * interval).cwiseSqrt()) : Vector3d::Constant(kNaN);
  for (int axis = 0; axis < 3; ++axis) {
    t.quantum(axis) = smallest_step(stored, axis);
    t.repeated(axis) = repeated(stored, axis);
    std::tie(t.limit(axis), t.clipped[static_cast<std::size_t>(axis)]) = clipping(stored, axis, t.quantum(axis));
    if (imu.increments) t.limit(axis) /= interval;
  }
  return t;
}

std::vector<Interval> frozen(const ImuRecording& imu) {
  std::vector<Interval> found;
  for (std::size_t begin = 0, i = 1; i <= imu.time.size(); ++i) {
    if (i < imu.time.size() && imu.gyro[i] == imu.gyro[begin] && imu.accel[i] == imu.accel[begin]) continue;
    if (i - begin >= kFrozenRows) found.push_back({imu.time[begin], imu.time[i - 1]});
    begin = i;
  }
  return found;
}

// Whether so many rates exceed those of any body that the unit must be degrees.
bool turns_too_fast(const Values& gyro) { return quantile(norms_of(gyro), 0.99) > kFastRates; }

}  // namespace

ImuHealth imu_health(const ImuRecording& imu, const std::vector<Interval>& moving) {
  ImuHealth h;
  h.sampling = sampling(imu.time);
  h.increments = imu.increments;
  const Values gyro = rates_of(imu, imu.gyro), accel = rates_of(imu, imu.accel);
  const std::vector<double> forces = norms_of(accel);
  const double force = median(forces);
  h.has_gravity = quantile(forces, kMostForces) < kGravityRange * quantile(forces, kLeastForces);
  const auto quiet = without(quiet_rows(imu, gyro, accel, force), imu.time, moving);
  Values at_rest;
  for (const auto& [begin, end] : quiet) {
    h.rest.push_back({imu.time[begin], imu.time[end - 1]});
    at_rest.insert(at_rest.end(), accel.begin() + static_cast<std::ptrdiff_t>(begin),
                   accel.begin() + static_cast<std::ptrdiff_t>(end));
  }
  h.force = at_rest.empty() ? force : median(norms_of(at_rest));
  if (h.has_gravity) h.force_unit = wrong_unit(h.force, h.sampling.interval, imu.increments);
  const double unit = h.force_unit ? h.force_unit->factor : 1;
  const SpikeOptions known;
  h.gyro = triad(imu, imu.gyro, gyro, {kFastestTurn, known.gyro}, quiet, h.sampling.interval);
  h.accel =
      triad(imu, imu.accel, accel, {kHardestKnock * unit, {known.accel.per_second * unit, known.accel.least * unit}},
            quiet, h.sampling.interval);
  h.fast_rates = turns_too_fast(gyro);
  h.frozen = frozen(imu);
  h.magnetic_rows = imu.magnetic.size();
  h.temperature_rows = imu.temperature.size();
  return h;
}

}  // namespace piste
