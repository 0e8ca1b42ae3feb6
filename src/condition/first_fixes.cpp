#include "condition/first_fixes.h"

#include <algorithm>
#include <cmath>

#include "piste/math/statistics.h"

namespace piste {
namespace {

constexpr double kAcceleration = 5;  // m/s²: that of a skier or a car over some steps
constexpr double kSigmas = 6;        // no leap by chance in some hundred steps

// Fixes that follow one another without a leap.
struct Level {
  std::size_t first = 0;
  Vector3d offset = Vector3d::Zero();  // from the first level
  double sigma = 0;                    // of it: the largest of a leap
  double time = 0;
};

// The excess of the step to fix k over that of the velocity around it, which is the median of up to eight steps: one
// outlying fix spoils two of them. Zero if the motion may explain it.
Vector3d leap_to(const std::vector<GnssFix>& fixes, std::size_t k, double& sigma) {
  std::vector<Vector3d> around;
  double longest = 0;
  constexpr std::size_t kEitherSide = 4;
  for (std::size_t i = k - std::min(k, kEitherSide); i <= k + kEitherSide; ++i) {
    if (i == 0 || i == k || i >= fixes.size()) continue;
    const double dt = fixes[i].time - fixes[i - 1].time;
    around.emplace_back((fixes[i].position - fixes[i - 1].position) / dt);
    longest = std::max(longest, dt);
  }
  constexpr std::size_t kFewest = 3;
  if (around.size() < kFewest) return Vector3d::Zero();
  const double dt = fixes[k].time - fixes[k - 1].time;
  Vector3d velocity;
  for (int axis = 0; axis < 3; ++axis) {
    std::vector<double> values;
    values.reserve(around.size());
    for (const Vector3d& v : around) values.push_back(v(axis));
    velocity(axis) = median(std::move(values));
  }
  const Vector3d leap = fixes[k].position - fixes[k - 1].position - dt * velocity;
  constexpr double kPositions = 2.5;  // of the variance of one position, for each of the step's two
  sigma = std::sqrt(kPositions * (fixes[k - 1].sigma_position.squaredNorm() + fixes[k].sigma_position.squaredNorm()));
  const double moved = kAcceleration * dt * (dt / 2 + longest);
  return leap.norm() > kSigmas * sigma + moved ? leap : Vector3d::Zero();
}

std::vector<Level> levels_of(const std::vector<GnssFix>& fixes, const FaultDetectionOptions& options) {
  const double end = fixes.front().time + 2 * options.distrust;
  std::vector<Level> levels(1);
  for (std::size_t k = 1; k < fixes.size() && fixes[k].time < end; ++k) {
    double sigma = 0;
    const Vector3d leap = leap_to(fixes, k, sigma);
    if (leap.norm() > options.slight) {
      const Level& last = levels.back();
      levels.push_back({.first = k, .offset = last.offset + leap, .sigma = std::max(last.sigma, sigma)});
    } else {
      levels.back().time += fixes[k].time - fixes[k - 1].time;
    }
  }
  return levels;
}

}  // namespace

FirstFixes widen_first_fixes(std::vector<GnssFix>& fixes, const FaultDetectionOptions& options, const World& world) {
  constexpr double kFarLonger = 3;  // a receiver that leaps half-way is left to the filter
  if (fixes.size() < 4) return {};
  const std::vector<Level> levels = levels_of(fixes, options);
  // The time for which the positions were at a level.
  const auto time_at = [&](const Level& place) {
    double time = 0;
    for (const Level& s : levels) {
      const double near = kSigmas * std::max({s.sigma, place.sigma, fixes.front().sigma_position.norm()});
      if ((s.offset - place.offset).norm() < near) time += s.time;
    }
    return time;
  };
  // A receiver that leaps now and then has outliers: the sum of its leaps is not a position error.
  constexpr std::size_t kManyLeaps = 20;  // one fix in so many
  const auto looked = std::ranges::count_if(
      fixes, [&](const GnssFix& fix) { return fix.time < fixes.front().time + 2 * options.distrust; });
  if (levels.size() > 2 + static_cast<std::size_t>(looked) / kManyLeaps) return {};
  const double begun = time_at(levels.front());
  const auto longest = std::max_element(levels.begin(), levels.end(),
                                        [&](const Level& a, const Level& b) { return time_at(a) < time_at(b); });
  if (longest == levels.begin() || time_at(*longest) < kFarLonger * begun) return {};
  // Their error is common: each sigma is such that the sigma of their mean is that error.
  const double as_one = std::sqrt(static_cast<double>(longest->first));
  for (std::size_t i = 0; i < longest->first; ++i) {
    const Vector3d off = as_one * (world.rotation_wn(fixes[i].position).transpose() * longest->offset);
    fixes[i].sigma_position = (fixes[i].sigma_position.array().square() + off.array().square()).sqrt();
  }
  return {longest->first, longest->offset.norm()};
}

}  // namespace piste
