#include "piste/tune/standing_heights.h"

#include <algorithm>
#include <cmath>

#include "piste/math/statistics.h"

namespace piste {
namespace {

constexpr double kLevel = 0.01;  // of the height's: a coloured error of north and east that is next to none

}  // namespace

double StandingHeights::sigma() const { return std::hypot(slow, white); }

GaussMarkov StandingHeights::process() const { return {slow * Vector3d(kLevel, kLevel, 1), kStandingTime}; }

bool is_of_heights_alone(const PositionDrift& drift) {
  return !drift.of_stated && drift.sigma.head<2>().maxCoeff() < 2 * kLevel * drift.sigma.z();
}

StandingHeights standing_heights(const std::vector<double>& height) {
  constexpr std::size_t kFew = 20;
  constexpr double kMostly = 0.75, kNearlyAll = 0.95, kSmallest = 0.05;  // shares
  constexpr double kSame = 1e-3, kMetre = 1;                             // m
  constexpr double kTolerance = 0.02;                                    // of a change: that of a geoid is added
  if (height.size() < kFew) return {};
  std::vector<double> changes;
  std::size_t standing = 0;
  double other = height.front();  // the last height before this one that differs from it
  for (std::size_t i = 1; i < height.size(); ++i) {
    const double change = std::abs(height[i] - height[i - 1]);
    const bool same = change < kSame, back = std::abs(height[i] - other) < kSame;
    standing += same || back ? 1 : 0;
    if (same) continue;
    changes.push_back(change);
    other = height[i - 1];
  }
  if (static_cast<double>(standing) < kMostly * static_cast<double>(height.size() - 1)) return {};
  const double step = changes.empty() ? kMetre : quantile(changes, kSmallest);
  const auto multiples = std::count_if(changes.begin(), changes.end(), [step](double change) {
    return std::abs(change - std::round(change / step) * step) < kTolerance * change;
  });
  if (static_cast<double>(multiples) < kNearlyAll * static_cast<double>(changes.size())) return {};
  return {step / std::sqrt(12), step / 2};
}

StandingHeights standing_heights(const std::vector<GeodeticFix>& fixes) {
  std::vector<double> height;
  height.reserve(fixes.size());
  for (const GeodeticFix& fix : fixes) height.push_back(fix.position.height);
  return standing_heights(height);
}

StandingHeights standing_heights(const std::vector<GnssFix>& fixes, const World& world) {
  std::vector<double> height;
  height.reserve(fixes.size());
  for (const GnssFix& fix : fixes) height.push_back(world.to_geodetic(fix.position).height);
  return standing_heights(height);
}

}  // namespace piste
