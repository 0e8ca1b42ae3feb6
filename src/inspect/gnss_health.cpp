#include "piste/inspect/gnss_health.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <span>

#include "piste/math/statistics.h"
#include "piste/math/units.h"
#include "velocity_fit.h"

namespace piste {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr double kMetresPerRadian = 6371e3;
constexpr double kStanding = 0.1;     // m/s
constexpr double kShortestStand = 5;  // s

// Standard deviation of each axis, robust against a few outliers.
Vector3d scatter_of(const std::vector<Vector3d>& values) {
  if (values.empty()) return Vector3d::Constant(kNaN);
  const Vector3d middle = median_by_axis(values);
  std::vector<Vector3d> off;
  off.reserve(values.size());
  for (const Vector3d& v : values) off.emplace_back((v - middle).cwiseAbs());
  return kSigmaOverMedian * median_by_axis(off);
}

// The largest decimal step, in one of the units, of which nearly all values are multiples. 0 if it is smaller than
// `finest`.
double decimal_step(const std::vector<double>& values, std::span<const double> units, double finest) {
  constexpr double kNearly = 0.99, kTolerance = 0.1;
  const bool constant = std::all_of(values.begin(), values.end(), [&](double v) { return v == values.front(); });
  if (constant) return 0;
  double largest = 0;
  for (const double unit : units) {
    for (double step = 1; step * unit > std::max(finest, largest); step /= 10) {
      const auto hits = std::count_if(values.begin(), values.end(), [&](double v) {
        const double size = step * unit;
        return std::abs(v - std::round(v / size) * size) < kTolerance * finest;
      });
      if (static_cast<double>(hits) < kNearly * static_cast<double>(values.size())) continue;
      largest = step * unit;
      break;
    }
  }
  return largest;
}

Vector3d quantum_of(const std::vector<GeodeticFix>& fixes) {
  constexpr std::array<double, 3> kAngles{kDegree, kDegree / 60, kDegree / 3600};
  constexpr std::array<double, 1> kMetre{1};
  constexpr double kFinest = 1e-3;  // m
  std::vector<double> latitude, longitude, height;
  for (const GeodeticFix& f : fixes) {
    latitude.push_back(f.position.latitude);
    longitude.push_back(f.position.longitude);
    height.push_back(f.position.height);
  }
  const double metres_east = kMetresPerRadian * std::cos(latitude.front());
  return {kMetresPerRadian * decimal_step(latitude, kAngles, kFinest / kMetresPerRadian),
          metres_east * decimal_step(longitude, kAngles, kFinest / metres_east), decimal_step(height, kMetre, kFinest)};
}

// Velocity at each fix as a mean over about a second: of the velocities, or else from the positions.
std::vector<Vector3d> mean_velocities(const std::vector<GeodeticFix>& fixes, const Positions& p, bool measured) {
  constexpr double kHalf = 0.5;  // s
  std::vector<Vector3d> mean(fixes.size(), Vector3d::Zero());
  std::size_t begin = 0, end = 0;
  for (std::size_t i = 0; i < fixes.size(); ++i) {
    while (fixes[begin].time < fixes[i].time - kHalf) ++begin;
    while (end < fixes.size() && fixes[end].time <= fixes[i].time + kHalf) ++end;
    std::size_t first = begin, last = end - 1, count = 0;
    if (measured) {
      for (std::size_t k = first; k <= last; ++k) {
        if (!fixes[k].velocity) continue;
        mean[i] += fixes[k].velocity->value;
        ++count;
      }
      if (count > 0) mean[i] /= static_cast<double>(count);
      continue;
    }
    if (first == last) {  // a slow receiver
      if (i > 0) --first;
      if (last + 1 < fixes.size()) ++last;
    }
    if (last > first) mean[i] = (p[last] - p[first]) / (fixes[last].time - fixes[first].time);
  }
  return mean;
}

// White noise of the positions, all axes pooled, from second differences, which a steady motion does not affect.
double white_noise(const Positions& p) {
  const double kMedianNorm = 1.54;  // of three normal numbers
  std::vector<double> differences;
  differences.reserve(p.size());
  for (std::size_t i = 2; i < p.size(); ++i) differences.push_back((p[i] - 2 * p[i - 1] + p[i - 2]).norm());
  return std::sqrt(3.0 / 6.0) / kMedianNorm * median(std::move(differences));
}

// Adds fixes [first, last) as stationary if they scatter within their own noise; else tries both halves.
void add_standing(const std::vector<GeodeticFix>& fixes, const Positions& p, std::size_t first, std::size_t last,
                  double white, std::vector<Interval>& rest) {
  constexpr double kWander = 3, kSway = 0.3;  // white sigmas, m
  if (last <= first + 1 || fixes[last - 1].time - fixes[first].time < kShortestStand) return;
  Vector3d mean = Vector3d::Zero();
  for (std::size_t i = first; i < last; ++i) mean += p[i] / static_cast<double>(last - first);
  double squares = 0;
  for (std::size_t i = first; i < last; ++i) squares += (p[i] - mean).squaredNorm();
  if (std::sqrt(squares / static_cast<double>(last - first)) < kWander * white + kSway) {
    rest.push_back({fixes[first].time, fixes[last - 1].time});
    return;
  }
  const std::size_t middle = first + (last - first) / 2;
  add_standing(fixes, p, first, middle, white, rest);
  add_standing(fixes, p, middle, last, white, rest);
}

// Stationary times. `noise`: of the velocities. If it would hide a walk, the positions must be stationary too.
std::vector<Interval> find_rest(const std::vector<GeodeticFix>& fixes, const Positions& p,
                                const std::vector<Vector3d>& velocity, double noise, double interval) {
  const double white = white_noise(p);
  std::vector<Interval> rest;
  for (std::size_t i = 0; i < fixes.size();) {
    std::size_t j = i;
    while (j < fixes.size() && velocity[j].norm() < kStanding + 3 * noise &&
           (j == i || fixes[j].time - fixes[j - 1].time < 2.5 * interval)) {
      ++j;
    }
    if (3 * noise > kStanding) {
      add_standing(fixes, p, i, j, white, rest);
    } else if (j > i && fixes[j - 1].time - fixes[i].time >= kShortestStand) {
      rest.push_back({fixes[i].time, fixes[j - 1].time});
    }
    i = std::max(j, i + 1);
  }
  return rest;
}

Vector3d scatter_at_rest(const std::vector<GeodeticFix>& fixes, const Positions& p, const std::vector<Interval>& rest) {
  if (rest.empty()) return Vector3d::Constant(kNaN);
  const Interval longest = *std::max_element(
      rest.begin(), rest.end(), [](const Interval& a, const Interval& b) { return a.end - a.start < b.end - b.start; });
  std::vector<Vector3d> at_rest;
  for (std::size_t i = 0; i < fixes.size(); ++i) {
    if (longest.contains(fixes[i].time)) at_rest.push_back(p[i]);
  }
  return scatter_of(at_rest);
}

// The fixes with velocities interpolated to their own times, where the log's velocities come late by `delay`.
std::vector<GeodeticFix> with_velocities_of(const std::vector<GeodeticFix>& fixes, double delay) {
  std::vector<GeodeticFix> in_time = fixes;
  std::size_t j = 1;
  for (GeodeticFix& fix : in_time) {
    const double time = fix.time + delay;
    while (j + 1 < fixes.size() && fixes[j].time < time) ++j;
    const GeodeticFix &a = fixes[j - 1], &b = fixes[j];
    if (time < a.time || time > b.time || !a.velocity || !b.velocity) {
      fix.velocity.reset();
    } else if (fix.velocity) {
      fix.velocity->value =
          a.velocity->value + (time - a.time) / (b.time - a.time) * (b.velocity->value - a.velocity->value);
    }
  }
  return in_time;
}

Vector3d fix_noise(const std::vector<GeodeticFix>& fixes, const Positions& p, const GnssHealth& h) {
  constexpr double kShort = 0.3;  // s: within it a body moves evenly
  const auto still = [&](std::size_t first, std::size_t last) {
    return std::any_of(h.rest.begin(), h.rest.end(), [&](const Interval& r) {
      return r.contains(fixes[first].time) && r.contains(fixes[last].time);
    });
  };
  std::vector<Vector3d> left;
  double root = std::numbers::sqrt2;
  for (std::size_t i = 1; i < fixes.size(); ++i) {
    const double dt = fixes[i].time - fixes[i - 1].time;
    if (dt > 1.5 * h.sampling.interval || (dt > kShort && !still(i - 1, i))) continue;
    if (const auto step = beyond_velocity(fixes[i - 1], fixes[i], p[i] - p[i - 1], h.velocity)) left.push_back(*step);
  }
  if (left.size() < 10) {  // without velocities: third differences, at rest
    left.clear();
    root = std::sqrt(20.0);
    for (std::size_t i = 3; i < fixes.size(); ++i) {
      if (!still(i - 3, i)) continue;
      left.emplace_back(p[i] - 3 * p[i - 1] + 3 * p[i - 2] - p[i - 3]);
    }
    if (left.size() < 10) return Vector3d::Constant(kNaN);
  }
  return scatter_of(left) / root;
}

std::vector<Interval> find_repeated(const std::vector<GeodeticFix>& fixes, const Positions& p, const GnssHealth& h) {
  constexpr std::size_t kFewest = 3;
  std::vector<Interval> found;
  for (std::size_t i = 0; i + 1 < fixes.size();) {
    std::size_t j = i;
    while (j + 1 < fixes.size() && p[j + 1] == p[i]) ++j;
    if (j - i + 1 >= kFewest && j + 1 < fixes.size()) {
      const double moved = (p[j + 1] - p[i]).norm();
      const bool far = moved > 3 * h.quantum.norm() + 5 * fixes[i].sigma_position.norm();
      if (far && moved > kSurelyMoving * (fixes[j + 1].time - fixes[i].time))
        found.push_back({fixes[i].time, fixes[j].time});
    }
    i = j + 1;
  }
  return found;
}

// Largest plausible deviation of fixes a and b from the expected step. The motion itself may contribute `curvature`
// [m/s²] times the square of the time between them.
double jump_bound(const GeodeticFix& a, const GeodeticFix& b, const GnssHealth& h, double curvature) {
  constexpr double kFarOut = 8, kShortest = 1;  // sigmas; m
  const double scatter = h.noise.allFinite() ? h.noise.norm() : 0;
  const double claimed = std::hypot(a.sigma_position.norm(), b.sigma_position.norm());
  const double dt = b.time - a.time;
  return kShortest + kFarOut * std::max(std::numbers::sqrt2 * scatter, claimed) + curvature * dt * dt +
         h.quantum.norm();
}

// Largest distance that the body may have moved unobserved, if the step to fix i touches a stretch of repeated fixes; 0
// elsewhere. A step beyond it is a jump, also next to such a stretch.
double unseen_way(const std::vector<GeodeticFix>& fixes, const GnssHealth& h, std::size_t i) {
  // Factor on the log's top speed; m/s, an airliner's, as the top speed may be a jump itself.
  constexpr double kFaster = 2, kFastest = 300;
  double unseen = 0;  // s
  for (const Interval& r : h.repeated) {
    const double before = fixes[i - 1].time, now = fixes[i].time;
    if (now >= r.start && before <= r.end) unseen += r.end - r.start + now - before;
  }
  return unseen * std::min(kFaster * h.top_speed, kFastest);
}

// Steps that the velocities do not explain.
std::vector<PositionJump> jumps_against_velocity(const std::vector<GeodeticFix>& fixes, const Positions& p,
                                                 const GnssHealth& h) {
  constexpr double kCurvature = 4;  // m/s²
  std::vector<Vector3d> step(fixes.size(), Vector3d::Zero());
  for (std::size_t i = 1; i < fixes.size(); ++i) {
    step[i] = beyond_velocity(fixes[i - 1], fixes[i], p[i] - p[i - 1], h.velocity).value_or(Vector3d::Zero());
  }
  std::vector<PositionJump> jumps;
  for (std::size_t i = 1; i < fixes.size(); ++i) {
    const double limit = jump_bound(fixes[i - 1], fixes[i], h, kCurvature);
    if (step[i].norm() < limit || step[i].norm() < limit + unseen_way(fixes, h, i)) continue;
    jumps.push_back({fixes[i].time, step[i].norm()});
    if (i + 1 < fixes.size() && (step[i] + step[i + 1]).norm() < limit) ++i;  // the jump back
  }
  return jumps;
}

// Fixes that are off the line between their neighbours, by more than these neighbours are.
std::vector<PositionJump> jumps_off_the_line(const std::vector<GeodeticFix>& fixes, const Positions& p,
                                             const GnssHealth& h) {
  constexpr double kCurvature = 2.5;  // m/s²
  const auto off = [&](std::size_t i) {
    if (i == 0 || i + 1 >= fixes.size()) return 0.0;
    const double part = (fixes[i].time - fixes[i - 1].time) / (fixes[i + 1].time - fixes[i - 1].time);
    return (p[i] - (1 - part) * p[i - 1] - part * p[i + 1]).norm();
  };
  std::vector<PositionJump> jumps;
  for (std::size_t i = 1; i + 1 < fixes.size(); ++i) {
    const double distance = off(i);
    const double limit = jump_bound(fixes[i - 1], fixes[i + 1], h, kCurvature);
    if (distance < limit || distance < off(i - 1) || distance < off(i + 1)) continue;
    if (distance < limit + unseen_way(fixes, h, i) + unseen_way(fixes, h, i + 1)) continue;
    jumps.push_back({fixes[i].time, distance});
  }
  return jumps;
}

}  // namespace

GnssHealth gnss_health(const GnssRecording& gnss) {
  GnssHealth h;
  const std::vector<GeodeticFix>& fixes = gnss.fixes;
  std::vector<double> time;
  std::vector<Vector3d> sigmas;
  std::vector<double> sigma_velocity;
  h.lowest = kInfinity;
  h.highest = -kInfinity;
  h.quantum.setZero();
  h.rest_scatter = h.noise = Vector3d::Constant(kNaN);
  for (const GeodeticFix& f : fixes) {
    time.push_back(f.time);
    sigmas.push_back(f.sigma_position);
    ++h.qualities[static_cast<std::size_t>(f.quality)];
    if (!(f.sigma_position.minCoeff() > 0)) ++h.without_sigma;
    if (f.velocity) {
      ++h.velocities;
      sigma_velocity.push_back(f.velocity->sigma.norm());
    }
    h.lowest = std::min(h.lowest, f.position.height);
    h.highest = std::max(h.highest, f.position.height);
  }
  h.sampling = sampling(time);
  h.without_fix = gnss.without_fix;
  if (fixes.size() < 3) return h;
  h.median_sigma = median_by_axis(sigmas);
  h.smallest_sigma = h.largest_sigma = sigmas.front();
  for (const Vector3d& s : sigmas) {
    h.smallest_sigma = h.smallest_sigma.cwiseMin(s);
    h.largest_sigma = h.largest_sigma.cwiseMax(s);
  }
  const Positions p = positions_of(fixes);
  h.quantum = quantum_of(fixes);
  const bool measured = 2 * h.velocities > fixes.size();
  const std::vector<Vector3d> velocity = mean_velocities(fixes, p, measured);
  if (!sigma_velocity.empty()) h.sigma_velocity = median(sigma_velocity) / std::sqrt(3);
  const double in_a_second = std::sqrt(std::max(1.0, h.sampling.rate()));
  constexpr double kNotKnown = 5;  // m/s: phones state 20 m/s for an unknown sigma, which is no noise
  const bool stated = measured && median(sigma_velocity) < kNotKnown;
  const double noise =
      stated ? median(sigma_velocity) / in_a_second : 2 * std::min(h.median_sigma.norm(), white_noise(p));
  h.rest = find_rest(fixes, p, velocity, noise, h.sampling.interval);
  std::vector<double> speeds;
  speeds.reserve(velocity.size());
  for (const Vector3d& v : velocity) speeds.push_back(v.norm());
  h.top_speed = quantile(speeds, 0.99);
  std::erase_if(speeds, [](double v) { return v < kSurelyMoving; });
  h.speed = speeds.empty() ? 0 : median(std::move(speeds));
  const bool sparse = h.sampling.interval > kSparseFixes;
  if (sparse) h.rest.clear();
  h.rest_scatter = scatter_at_rest(fixes, p, h.rest);
  h.velocity = fit_velocity(fixes, p, h);
  const auto delay = h.velocity ? h.velocity->known_delay() : std::nullopt;
  const std::vector<GeodeticFix> in_time = delay ? with_velocities_of(fixes, *delay) : fixes;
  if (!sparse) h.noise = fix_noise(in_time, p, h);
  h.repeated = find_repeated(fixes, p, h);
  h.jumps = h.velocities > fixes.size() / 2 ? jumps_against_velocity(in_time, p, h) : jumps_off_the_line(fixes, p, h);
  return h;
}

}  // namespace piste
