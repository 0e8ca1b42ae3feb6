#include "velocity_fit.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <utility>

#include "math/time.h"
#include "piste/math/earth.h"
#include "piste/math/statistics.h"
#include "signed_permutations.h"

namespace piste {
namespace {

constexpr std::size_t kFewestPairs = 20;

// Over a second or more: the mean velocity by the positions, and the mean of the velocities.
struct Pair {
  Vector3d moved, velocity, acceleration;
};

std::vector<Pair> pairs_of(const std::vector<GeodeticFix>& fixes, const Positions& p, double length, double interval) {
  std::vector<Pair> pairs;
  std::size_t j = 0;
  Vector3d area = Vector3d::Zero();           // integral of the velocities since the first fix
  std::vector<Vector3d> areas(fixes.size());  // the same up to each fix
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

// A hypothesis about the columns, and how much it differs from the labels.
struct VelocityReading {
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
  double scale;                 // value of 1 m/s in this unit
  std::string_view name, unit;  // in words, and as written in configurations
};
constexpr std::array kSpeedUnits = std::to_array<SpeedUnit>({{1, "m/s", "m/s"},
                                                             {3.6, "km/h", "km/h"},
                                                             {kHour / 1852, "knots", "kn"},
                                                             {kHour / 1609.344, "miles/h", "0.44704 m/s"},
                                                             {1 / 0.3048, "ft/s", "0.3048 m/s"}});

const SpeedUnit& speed_unit(double scale) {
  return *std::find_if(kSpeedUnits.begin(), kSpeedUnits.end(), [&](const SpeedUnit& u) { return u.scale == scale; });
}

std::vector<VelocityReading> readings() {
  std::vector<VelocityReading> all;
  for (const SpeedUnit& unit : kSpeedUnits) {
    for (const Matrix3d& axes : signed_permutations()) {
      all.push_back({axes, unit.scale, false, oddity_of(axes) + (unit.scale == 1 ? 0 : 2)});
    }
  }
  // Whoever interchanged east and north for positions may have done so for velocities.
  const Matrix3d east_north = Matrix3d{{0, 1, 0}, {1, 0, 0}, {0, 0, 1}};
  all.push_back({.interchanged = true, .oddity = 4});
  all.push_back({.axes = east_north, .interchanged = true, .oddity = 5});
  return all;
}

// The delay, by least squares of the residuals of the velocities on −acceleration: v(t) ≈ p'(t) − delay p''(t).
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
  fit.sigma_delay = std::numeric_limits<double>::infinity();
  if (!(aa > 0)) return;
  fit.delay = ra / aa;
  const double free = 3 * independent * static_cast<double>(pairs.size()) - 1;
  if (free > 0) fit.sigma_delay = std::sqrt(std::max(0.0, rr - ra * ra / aa) / (free / independent) / aa / independent);
}

// Pairs of the fixes in motion.
std::vector<Pair> pairs_in_motion(const std::vector<GeodeticFix>& fixes, const Positions& p, double length,
                                  double interval) {
  std::vector<Pair> pairs = pairs_of(fixes, p, length, interval);
  std::erase_if(pairs, [](const Pair& pair) {
    return pair.moved.norm() < kSurelyMoving || pair.velocity.norm() < kSurelyMoving;
  });
  return pairs;
}

// Keeps the velocities as given unless one hypothesis is clearly better. Of all hypotheses nearly as good as the best,
// takes the one that differs least from the labels.
void choose_reading(const std::vector<Pair>& as_given, const std::vector<Pair>& other, VelocityFit& fit) {
  constexpr double kClearly = 0.5, kHardlyWorse = 1.15, kLeast = 0.3;  // parts, and m/s
  std::vector<std::pair<double, VelocityReading>> tried;
  for (const VelocityReading& r : readings()) {
    if (r.interchanged && other.empty()) continue;
    tried.emplace_back(residual_of(r.interchanged ? other : as_given, r.scale * r.axes), r);
  }
  const double least = std::min_element(tried.begin(), tried.end(), [](const auto& a, const auto& b) {
                         return a.first < b.first;
                       })->first;
  if (fit.residual_as_given > kLeast && least < kClearly * fit.residual_as_given) {
    std::erase_if(tried, [&](const auto& t) { return t.first > kHardlyWorse * least; });
    const auto& [residual, reading] = *std::min_element(
        tried.begin(), tried.end(), [](const auto& a, const auto& b) { return a.second.oddity < b.second.oddity; });
    fit.residual = residual;
    fit.axes = reading.axes;
    fit.scale = reading.scale;
    fit.interchanged = reading.interchanged;
  }
}

}  // namespace

Positions positions_of(const std::vector<GeodeticFix>& fixes) {
  const World world(fixes.front().position);
  Positions p;
  p.reserve(fixes.size());
  for (const GeodeticFix& f : fixes) p.push_back(world.from_geodetic(f.position));
  return p;
}

std::vector<GeodeticFix> interchanged(std::vector<GeodeticFix> fixes) {
  for (GeodeticFix& f : fixes) std::swap(f.position.latitude, f.position.longitude);
  return fixes;
}

bool may_be_interchanged(const std::vector<GeodeticFix>& fixes) {
  return std::all_of(fixes.begin(), fixes.end(),
                     [](const GeodeticFix& f) { return std::abs(f.position.longitude) < std::numbers::pi / 2; });
}

std::string_view speed_unit_name(double scale) { return speed_unit(scale).name; }

std::string_view speed_unit_text(double scale) { return speed_unit(scale).unit; }

std::optional<VelocityFit> fit_velocity(const std::vector<GeodeticFix>& fixes, const Positions& p,
                                        const GnssHealth& h) {
  const double interval = h.sampling.interval;
  const double coarse = std::max(h.quantum.head<2>().maxCoeff(), 3 * h.median_sigma.head<2>().maxCoeff());
  const double length = std::clamp(2 * coarse, std::max(1.0, 2 * interval), 20.0);
  const std::vector<Pair> as_given = pairs_in_motion(fixes, p, length, interval);
  if (as_given.size() < kFewestPairs) return std::nullopt;
  std::vector<Pair> other;
  if (may_be_interchanged(fixes)) {
    const std::vector<GeodeticFix> swapped = interchanged(fixes);
    other = pairs_in_motion(swapped, positions_of(swapped), length, interval);
  }
  VelocityFit fit;
  fit.residual_as_given = residual_of(as_given, Matrix3d::Identity());
  fit.residual = fit.residual_as_given;
  choose_reading(as_given, other, fit);
  fit_delay(fit.interchanged ? other : as_given, std::min(1.0, interval / length), fit);
  return fit;
}

std::optional<Vector3d> beyond_velocity(const GeodeticFix& before, const GeodeticFix& now, const Vector3d& step,
                                        const std::optional<VelocityFit>& fit) {
  if (!before.velocity || !now.velocity) return std::nullopt;
  Vector3d mean = (before.velocity->value + now.velocity->value) / 2;
  if (fit) mean = fit->axes.transpose() * mean / fit->scale;
  return step - (now.time - before.time) * mean;
}

}  // namespace piste
