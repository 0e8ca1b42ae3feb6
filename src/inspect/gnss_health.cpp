#include "piste/inspect/gnss_health.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <span>

#include "math/time.h"
#include "piste/math/earth.h"
#include "piste/math/statistics.h"
#include "signed_permutations.h"

namespace piste {
namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr double kDegrees = 180 / std::numbers::pi;
constexpr double kMetresPerRadian = 6371e3;
constexpr double kOfNormal = 1.4826;  // standard deviation over median magnitude, of a normal distribution
constexpr double kStanding = 0.1;     // m/s
constexpr double kShortestRest = 5;   // s
constexpr double kMoving = 1;         // m/s: surely
constexpr double kFewestPairs = 20;
constexpr double kFastest = 200, kSlowest = 0.05;  // Hz that a receiver may have

using Positions = std::vector<Vector3d>;

Vector3d median_of(const std::vector<Vector3d>& values) {
  Vector3d middle;
  for (int axis = 0; axis < 3; ++axis) {
    std::vector<double> one;
    one.reserve(values.size());
    for (const Vector3d& v : values) one.push_back(v(axis));
    middle(axis) = median(std::move(one));
  }
  return middle;
}

// Standard deviation of each axis, whatever a few outliers say.
Vector3d scatter_of(const std::vector<Vector3d>& values) {
  if (values.empty()) return Vector3d::Constant(kNan);
  const Vector3d middle = median_of(values);
  std::vector<Vector3d> off;
  off.reserve(values.size());
  for (const Vector3d& v : values) off.emplace_back((v - middle).cwiseAbs());
  return kOfNormal * median_of(off);
}

Positions positions_of(const std::vector<GeodeticFix>& fixes) {
  const World world(fixes.front().position);
  Positions p;
  p.reserve(fixes.size());
  for (const GeodeticFix& f : fixes) p.push_back(world.from_geodetic(f.position));
  return p;
}

// Largest step, decimal in one of the units, that nearly all values are multiples of; 0 where finer than `finest`.
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
  constexpr std::array<double, 3> kAngles{1 / kDegrees, 1 / kDegrees / 60, 1 / kDegrees / 3600};
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

// Velocity about each fix, the mean of a second or so: of the velocities, else from the positions.
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

// Of the white noise of positions, all axes together: second differences, in which a steady motion does not show.
double white_noise(const Positions& p) {
  const double kMedianNorm = 1.54;  // of three normal numbers
  std::vector<double> differences;
  differences.reserve(p.size());
  for (std::size_t i = 2; i < p.size(); ++i) differences.push_back((p[i] - 2 * p[i - 1] + p[i - 2]).norm());
  return std::sqrt(3.0 / 6.0) / kMedianNorm * median(std::move(differences));
}

std::vector<Interval> find_rest(const std::vector<GeodeticFix>& fixes, const std::vector<Vector3d>& velocity,
                                double noise, double interval) {
  std::vector<Interval> rest;
  for (std::size_t i = 0; i < fixes.size();) {
    std::size_t j = i;
    while (j < fixes.size() && velocity[j].norm() < kStanding + 3 * noise &&
           (j == i || fixes[j].time - fixes[j - 1].time < 2.5 * interval)) {
      ++j;
    }
    if (j > i && fixes[j - 1].time - fixes[i].time >= kShortestRest) rest.push_back({fixes[i].time, fixes[j - 1].time});
    i = std::max(j, i + 1);
  }
  return rest;
}

Vector3d scatter_at_rest(const std::vector<GeodeticFix>& fixes, const Positions& p, const std::vector<Interval>& rest) {
  if (rest.empty()) return Vector3d::Constant(kNan);
  const Interval longest = *std::max_element(
      rest.begin(), rest.end(), [](const Interval& a, const Interval& b) { return a.end - a.start < b.end - b.start; });
  std::vector<Vector3d> at_rest;
  for (std::size_t i = 0; i < fixes.size(); ++i) {
    if (longest.contains(fixes[i].time)) at_rest.push_back(p[i]);
  }
  return scatter_of(at_rest);
}

// ---- Velocities against positions. ----

// Over a second or more: how far the positions went, and the mean of the velocities.
struct Pair {
  Vector3d moved, velocity, acceleration;
};

std::vector<Pair> pairs_of(const std::vector<GeodeticFix>& fixes, const Positions& p, double length, double interval) {
  std::vector<Pair> pairs;
  std::size_t j = 0;
  Vector3d area = Vector3d::Zero();           // of the velocities since the first fix
  std::vector<Vector3d> areas(fixes.size());  // up to each fix
  for (std::size_t i = 0; i < fixes.size(); ++i) {
    if (i > 0 && fixes[i].velocity && fixes[i - 1].velocity) {
      area += (fixes[i].time - fixes[i - 1].time) / 2 * (fixes[i].velocity->value + fixes[i - 1].velocity->value);
    }
    areas[i] = area;
  }
  std::size_t broken = 0;  // no pair across a gap, nor across a fix without velocity
  for (std::size_t i = 0; i < fixes.size(); ++i) {
    if (!fixes[i].velocity) {
      broken = i + 1;
      continue;
    }
    if (i > 0 && fixes[i].time - fixes[i - 1].time > 2.5 * interval) broken = i;
    while (j + 1 < i && fixes[i].time - fixes[j + 1].time > length - interval / 2) ++j;
    const double dt = fixes[i].time - fixes[j].time;
    if (j < broken || dt < length - interval / 2) continue;
    pairs.push_back(
        {(p[i] - p[j]) / dt, (areas[i] - areas[j]) / dt, (fixes[i].velocity->value - fixes[j].velocity->value) / dt});
  }
  return pairs;
}

double residual_of(const std::vector<Pair>& pairs, const Matrix3d& turn) {
  std::vector<double> left;
  left.reserve(pairs.size());
  for (const Pair& pair : pairs) left.push_back((pair.velocity - turn * pair.moved).norm());
  return median(std::move(left));
}

// A way to read the columns, and how far it is from taking them as they are.
struct Reading {
  Matrix3d axes = Matrix3d::Identity();
  double scale = 1;
  bool interchanged = false;
  int oddity = 0;
};

int oddity_of(const Matrix3d& axes) {
  Matrix3d enu;
  enu << 0, 1, 0, 1, 0, 0, 0, 0, -1;
  const Matrix3d up = Vector3d(1, 1, -1).asDiagonal();
  if (axes.isIdentity()) return 0;
  if (axes == enu || axes == up) return 2;
  if (axes == up * enu) return 3;
  return axes.isDiagonal() ? 5 : 6;
}

struct SpeedUnit {
  double scale;  // of what is 1 m/s
  std::string_view name;
};
constexpr std::array kSpeedUnits{SpeedUnit{1, "m/s"}, SpeedUnit{3.6, "km/h"}, SpeedUnit{kHour / 1852, "knots"},
                                 SpeedUnit{kHour / 1609.344, "miles/h"}, SpeedUnit{1 / 0.3048, "ft/s"}};

std::string_view unit_name(double scale) {
  return std::find_if(kSpeedUnits.begin(), kSpeedUnits.end(), [&](const SpeedUnit& u) { return u.scale == scale; })
      ->name;
}

std::vector<Reading> readings() {
  std::vector<Reading> all;
  for (const SpeedUnit& unit : kSpeedUnits) {
    for (const Matrix3d& axes : signed_permutations()) {
      all.push_back({axes, unit.scale, false, oddity_of(axes) + (unit.scale == 1 ? 0 : 2)});
    }
  }
  all.push_back({.interchanged = true, .oddity = 4});
  return all;
}

std::vector<GeodeticFix> interchanged(std::vector<GeodeticFix> fixes) {
  for (GeodeticFix& f : fixes) std::swap(f.position.latitude, f.position.longitude);
  return fixes;
}

bool may_be_interchanged(const std::vector<GeodeticFix>& fixes) {
  return std::all_of(fixes.begin(), fixes.end(),
                     [](const GeodeticFix& f) { return std::abs(f.position.longitude) < std::numbers::pi / 2; });
}

// Least squares of what is left of the velocities on −acceleration: v(t) ≈ p'(t) − delay p''(t).
void fit_delay(const std::vector<Pair>& pairs, double independent, VelocityFit& fit) {
  constexpr double kFar = 5;
  double ra = 0, aa = 0, rr = 0;
  for (const Pair& pair : pairs) {
    const Vector3d left = fit.axes.transpose() * pair.velocity / fit.scale - pair.moved;
    const Vector3d acceleration = fit.axes.transpose() * pair.acceleration / fit.scale;
    if (left.norm() > kFar * (fit.residual + 0.01)) continue;
    ra -= left.dot(acceleration);
    aa += acceleration.squaredNorm();
    rr += left.squaredNorm();
  }
  fit.sigma_delay = kInfinity;
  if (!(aa > 0)) return;
  fit.delay = ra / aa;
  const double free = 3 * independent * static_cast<double>(pairs.size()) - 1;
  if (free > 0) fit.sigma_delay = std::sqrt(std::max(0.0, rr - ra * ra / aa) / (free / independent) / aa / independent);
}

std::optional<VelocityFit> fit_velocity(const std::vector<GeodeticFix>& fixes, const Positions& p,
                                        const GnssHealth& h) {
  constexpr double kClearly = 0.5, kAsGood = 1.15, kLeast = 0.3;  // parts, and m/s
  const double coarse = std::max(h.quantum.head<2>().maxCoeff(), 3 * h.median_sigma.head<2>().maxCoeff());
  const double length = std::clamp(2 * coarse, std::max(1.0, 2 * h.sampling.interval), 20.0);
  const auto in_motion = [&](std::vector<Pair> pairs) {
    std::erase_if(pairs,
                  [](const Pair& pair) { return pair.moved.norm() < kMoving || pair.velocity.norm() < kMoving; });
    return pairs;
  };
  const std::vector<Pair> as_given = in_motion(pairs_of(fixes, p, length, h.sampling.interval));
  if (static_cast<double>(as_given.size()) < kFewestPairs) return std::nullopt;
  std::vector<Pair> other;
  if (may_be_interchanged(fixes)) {
    const std::vector<GeodeticFix> swapped = interchanged(fixes);
    other = in_motion(pairs_of(swapped, positions_of(swapped), length, h.sampling.interval));
  }
  VelocityFit fit;
  fit.residual_as_given = residual_of(as_given, Matrix3d::Identity());
  fit.residual = fit.residual_as_given;
  std::vector<std::pair<double, Reading>> tried;
  for (const Reading& r : readings()) {
    if (r.interchanged && other.empty()) continue;
    tried.emplace_back(residual_of(r.interchanged ? other : as_given, r.scale * r.axes), r);
  }
  const double least = std::min_element(tried.begin(), tried.end(), [](const auto& a, const auto& b) {
                         return a.first < b.first;
                       })->first;
  if (fit.residual_as_given > kLeast && least < kClearly * fit.residual_as_given) {
    std::erase_if(tried, [&](const auto& t) { return t.first > kAsGood * least; });
    const auto& [residual, reading] = *std::min_element(
        tried.begin(), tried.end(), [](const auto& a, const auto& b) { return a.second.oddity < b.second.oddity; });
    fit.residual = residual;
    fit.axes = reading.axes;
    fit.scale = reading.scale;
    fit.interchanged = reading.interchanged;
  }
  fit_delay(fit.interchanged ? other : as_given, std::min(1.0, h.sampling.interval / length), fit);
  return fit;
}

// ---- From fix to fix. ----

// What a step of the positions has beyond that of the velocities, as they are to be read.
std::optional<Vector3d> beyond_velocity(const GeodeticFix& before, const GeodeticFix& now, const Vector3d& step,
                                        const std::optional<VelocityFit>& fit) {
  if (!before.velocity || !now.velocity) return std::nullopt;
  Vector3d mean = (before.velocity->value + now.velocity->value) / 2;
  if (fit) mean = fit->axes.transpose() * mean / fit->scale;
  return step - (now.time - before.time) * mean;
}

Vector3d fix_noise(const std::vector<GeodeticFix>& fixes, const Positions& p, const GnssHealth& h) {
  constexpr double kShort = 0.3;  // s within which a body moves evenly
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
    if (left.size() < 10) return Vector3d::Constant(kNan);
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
      if (far && moved > kMoving * (fixes[j + 1].time - fixes[i].time)) found.push_back({fixes[i].time, fixes[j].time});
    }
    i = j + 1;
  }
  return found;
}

std::vector<PositionJump> find_jumps(const std::vector<GeodeticFix>& fixes, const Positions& p, const GnssHealth& h) {
  constexpr double kFarOut = 8, kShortest = 1;  // sigmas; m
  const double scatter = h.noise.allFinite() ? h.noise.norm() : 0;
  const auto bound = [&](std::size_t a, std::size_t b, double curvature) {
    const double claimed = std::hypot(fixes[a].sigma_position.norm(), fixes[b].sigma_position.norm());
    const double dt = fixes[b].time - fixes[a].time;
    return kShortest + kFarOut * std::max(std::numbers::sqrt2 * scatter, claimed) + curvature * dt * dt +
           h.quantum.norm();
  };
  const auto expected = [&](std::size_t i) {
    return std::any_of(h.repeated.begin(), h.repeated.end(),
                       [&](const Interval& r) { return fixes[i].time >= r.start && fixes[i - 1].time <= r.end; });
  };
  std::vector<PositionJump> jumps;
  if (h.velocities > fixes.size() / 2) {
    std::vector<Vector3d> step(fixes.size(), Vector3d::Zero());
    for (std::size_t i = 1; i < fixes.size(); ++i) {
      step[i] = beyond_velocity(fixes[i - 1], fixes[i], p[i] - p[i - 1], h.velocity).value_or(Vector3d::Zero());
    }
    for (std::size_t i = 1; i < fixes.size(); ++i) {
      const double limit = bound(i - 1, i, 4);
      if (step[i].norm() < limit || expected(i)) continue;
      jumps.push_back({fixes[i].time, step[i].norm()});
      if (i + 1 < fixes.size() && (step[i] + step[i + 1]).norm() < limit) ++i;  // and back
    }
    return jumps;
  }
  const auto off = [&](std::size_t i) {
    if (i == 0 || i + 1 >= fixes.size()) return 0.0;
    const double part = (fixes[i].time - fixes[i - 1].time) / (fixes[i + 1].time - fixes[i - 1].time);
    return (p[i] - (1 - part) * p[i - 1] - part * p[i + 1]).norm();
  };
  for (std::size_t i = 1; i + 1 < fixes.size(); ++i) {
    const double distance = off(i);
    if (distance < bound(i - 1, i + 1, 2.5) || distance < off(i - 1) || distance < off(i + 1)) continue;
    if (!expected(i) && !expected(i + 1)) jumps.push_back({fixes[i].time, distance});
  }
  return jumps;
}

// ---- In words. ----

std::string column_names(const Matrix3d& axes) {
  constexpr std::array<std::string_view, 3> kPositive{"north", "east", "down"}, kNegative{"south", "west", "up"};
  std::string text;
  for (int row = 0; row < 3; ++row) {
    Eigen::Index column = 0;
    axes.row(row).cwiseAbs().maxCoeff(&column);
    const auto name = static_cast<std::size_t>(column);
    text += fmt::format("{}{}", row > 0 ? ", " : "", axes(row, column) > 0 ? kPositive[name] : kNegative[name]);
  }
  return text;
}

void suspect_velocity(const VelocityFit& fit, const std::string& file, std::vector<Suspicion>& found) {
  constexpr double kLate = 0.03, kSure = 5;  // s; sigmas
  const std::string better = fmt::format("{:.2g} m/s off what the positions do where {:.2g} m/s are left so",
                                         fit.residual_as_given, fit.residual);
  const bool horizontal = fit.axes.topLeftCorner<2, 2>().isIdentity();
  if (fit.interchanged) {
    found.push_back({LogFault::kLatitudeLongitude, file,
                     "the velocities fit the positions once latitude and longitude are interchanged: " + better,
                     "interchange the columns latitude_deg and longitude_deg"});
  } else if (!horizontal) {
    found.push_back({LogFault::kVelocityEastNorth, file,
                     fmt::format("the columns velocity north, east, down hold {}: {}", column_names(fit.axes), better),
                     "name the columns for what they hold; `down` is minus `up`"});
  } else if (!fit.axes.isIdentity()) {
    found.push_back({LogFault::kVelocityUp, file, "the velocity down is positive upwards: " + better,
                     "reverse the sign of velocity_down_m_s"});
  }
  if (fit.scale != 1) {
    found.push_back({LogFault::kVelocityUnit, file,
                     fmt::format("the velocities are {:.3f} times what the positions do: {}, it seems; {}", fit.scale,
                                 unit_name(fit.scale), better),
                     fmt::format("divide the velocities and their sigmas by {:.4f}", fit.scale)});
  }
  if (fit.as_given() && std::abs(fit.delay) > kLate && std::abs(fit.delay) > kSure * fit.sigma_delay) {
    found.push_back({LogFault::kVelocityDelay, file,
                     fmt::format("the velocities come {:.3f} ± {:.3f} s {} against the positions", std::abs(fit.delay),
                                 fit.sigma_delay, fit.delay > 0 ? "late" : "early"),
                     "use the positions alone (`use: position`)"});
  }
}

void suspect_sigma(const GnssHealth& h, const std::string& file, std::vector<Suspicion>& found) {
  constexpr double kSmall = 3, kSmallAtRest = 4, kLarge = 10, kSway = 0.05;  // ratios; m
  const Vector3d claimed = h.median_sigma;
  if (h.without_sigma > 0) {
    found.push_back({LogFault::kSigmaTooSmall, file,
                     fmt::format("{} of {} fixes claim a sigma of 0", h.without_sigma, h.sampling.rows),
                     "give the receiver's own sigma, or leave these fixes out"});
    return;
  }
  const Vector3d noise = h.noise.cwiseMax(0), rest = (h.rest_scatter.array() - kSway).cwiseMax(0).matrix();
  const double by_noise = h.noise.allFinite() ? noise.cwiseQuotient(claimed).maxCoeff() : 0;
  const double by_rest = h.rest_scatter.allFinite() ? rest.cwiseQuotient(claimed).maxCoeff() : 0;
  if (by_noise > kSmall || by_rest > kSmallAtRest) {
    const bool noisy = by_noise / kSmall > by_rest / kSmallAtRest;
    const Vector3d seen = noisy ? h.noise : h.rest_scatter;
    found.push_back({LogFault::kSigmaTooSmall, file,
                     fmt::format("the positions {} by {:.3g} {:.3g} {:.3g} m (north, east, down) where {:.3g} {:.3g} "
                                 "{:.3g} m are claimed",
                                 noisy ? "scatter from fix to fix" : "wander at rest", seen.x(), seen.y(), seen.z(),
                                 claimed.x(), claimed.y(), claimed.z()),
                     fmt::format("multiply the sigmas by {:.2g}", std::max(by_noise, by_rest))});
  } else if (h.noise.allFinite() && h.rest_scatter.allFinite() &&
             (kLarge * noise.cwiseMax(h.rest_scatter).array() < claimed.array()).all()) {
    found.push_back(
        {LogFault::kSigmaTooLarge, file,
         fmt::format("sigmas of {:.3g} {:.3g} {:.3g} m are claimed where the positions scatter by {:.2g} "
                     "{:.2g} {:.2g} m at rest",
                     claimed.x(), claimed.y(), claimed.z(), h.rest_scatter.x(), h.rest_scatter.y(), h.rest_scatter.z()),
         "nothing, where the receiver knows of errors that a short rest does not show"});
  }
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
  h.rest_scatter = h.noise = Vector3d::Constant(kNan);
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
  h.median_sigma = median_of(sigmas);
  h.smallest_sigma = h.largest_sigma = sigmas.front();
  for (const Vector3d& s : sigmas) {
    h.smallest_sigma = h.smallest_sigma.cwiseMin(s);
    h.largest_sigma = h.largest_sigma.cwiseMax(s);
  }
  const Positions p = positions_of(fixes);
  h.quantum = quantum_of(fixes);
  const bool measured = 2 * h.velocities > fixes.size();
  const std::vector<Vector3d> velocity = mean_velocities(fixes, p, measured);
  const double in_a_second = std::sqrt(std::max(1.0, h.sampling.rate()));
  const double noise =
      measured ? median(sigma_velocity) / in_a_second : 2 * std::min(h.median_sigma.norm(), white_noise(p));
  h.rest = find_rest(fixes, velocity, noise, h.sampling.interval);
  std::vector<double> speeds;
  speeds.reserve(velocity.size());
  for (const Vector3d& v : velocity) speeds.push_back(v.norm());
  h.top_speed = quantile(speeds, 0.99);
  std::erase_if(speeds, [](double v) { return v < kMoving; });
  h.speed = speeds.empty() ? 0 : median(std::move(speeds));
  h.rest_scatter = scatter_at_rest(fixes, p, h.rest);
  h.velocity = fit_velocity(fixes, p, h);
  h.noise = fix_noise(fixes, p, h);
  h.repeated = find_repeated(fixes, p, h);
  h.jumps = find_jumps(fixes, p, h);
  return h;
}

std::vector<Suspicion> suspicions(const GnssHealth& h, const RowFaults& faults, const std::string& file) {
  std::vector<Suspicion> found = suspicions(h.sampling, faults, file, kFastest, kSlowest);
  const auto has = [&](LogFault fault) {
    return std::any_of(found.begin(), found.end(), [fault](const Suspicion& s) { return s.fault == fault; });
  };
  if (has(LogFault::kEmpty) || has(LogFault::kTimeUnit)) return found;
  const auto add = [&](LogFault fault, std::string what, std::string remedy) {
    found.push_back({fault, file, std::move(what), std::move(remedy)});
  };
  if (h.velocity) suspect_velocity(*h.velocity, file, found);
  // Rounding makes fixes repeat themselves, jump and scatter.
  const double rounding = h.quantum.head<2>().maxCoeff() / std::sqrt(12.0);
  if (rounding > 0.5 * h.median_sigma.head<2>().maxCoeff() && rounding > 0.005) {
    add(LogFault::kCoordinatesRounded,
        fmt::format("latitude and longitude are rounded to {:.3g} and {:.3g} m, where a sigma of {:.3g} m is claimed",
                    h.quantum.x(), h.quantum.y(), h.median_sigma.head<2>().maxCoeff()),
        "write degrees with nine decimals");
  } else {
    if (!h.repeated.empty()) {
      add(LogFault::kRepeatedFix,
          fmt::format("the same fix again and again while the antenna moves on, {} times; the first from t = {:.3f} to "
                      "{:.3f} s",
                      h.repeated.size(), h.repeated.front().start, h.repeated.front().end),
          "leave the repeated fixes out: the receiver had none");
    }
    if (!h.jumps.empty()) {
      const auto furthest =
          std::max_element(h.jumps.begin(), h.jumps.end(),
                           [](const PositionJump& a, const PositionJump& b) { return a.distance < b.distance; });
      add(LogFault::kPositionJumps,
          fmt::format(
              "{} positions jump, the furthest by {:.3g} m at t = {:.3f} s, where a sigma of {:.3g} m is claimed",
              h.jumps.size(), furthest->distance, furthest->time, h.median_sigma.maxCoeff()),
          "multipath, or a change of solution: the gate of replay rejects single ones; leave longer stretches out");
    }
    suspect_sigma(h, file, found);
  }
  if (h.velocities == 0) {
    add(LogFault::kNoVelocity, "no velocities", "log the receiver's velocities where it has them");
  }
  if (h.top_speed < kMoving) {
    add(LogFault::kNoMotion, fmt::format("the antenna moves at {:.2g} m/s at most", h.top_speed),
        "without motion the heading is not found");
  }
  if (h.without_fix > 0) {
    add(LogFault::kNoFix, fmt::format("{} epochs without a fix beside {} with one", h.without_fix, h.sampling.rows),
        "see where the antenna did not see the sky");
  }
  std::stable_sort(found.begin(), found.end(),
                   [](const Suspicion& a, const Suspicion& b) { return a.fault < b.fault; });
  return found;
}

}  // namespace piste
