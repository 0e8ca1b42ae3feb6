#include "piste/smoother/attitude_lag.h"

#include <algorithm>
#include <cmath>
#include <vector>

namespace piste {
namespace {

struct LagCorrelation {
  double lag, level, heading;
};

LagCorrelation correlation_of(const AttitudeLag& l) {
  const auto level = [](const Matrix3d& m) { return m(0, 0) + m(1, 1); };
  return {l.lag, level(l.covariance) / std::sqrt(level(l.of_early) * level(l.of_late)),
          l.covariance(2, 2) / std::sqrt(l.of_early(2, 2) * l.of_late(2, 2))};
}

}  // namespace

double correlation_time(std::span<const AttitudeLag> lags) {
  std::vector<LagCorrelation> correlations;
  double longest = 0;
  for (const AttitudeLag& l : lags) {
    correlations.push_back(correlation_of(l));
    longest = std::max(longest, l.lag);
  }
  const auto misfit = [&](double tau) {
    double sum = 0;
    for (const LagCorrelation& c : correlations) {
      const double model = std::exp(-c.lag / tau), level = c.level - model, heading = c.heading - model;
      sum += 2 * level * level + heading * heading;
    }
    return sum;
  };
  // The misfit may have several minima: a search in steps of 10 % over four decades, then in ever finer steps about the
  // best value.
  constexpr int kSteps = 96, kHalvings = 10;
  double best = longest, least = longest > 0 ? misfit(longest) : 0;
  const auto look = [&](double tau) {
    if (tau <= 0 || tau > longest) return;
    if (const double m = misfit(tau); m < least) {
      least = m;
      best = tau;
    }
  };
  for (int i = 1; i <= kSteps; ++i) look(longest * std::pow(1.1, -i));
  double step = 1.05;
  for (int i = 0; i < kHalvings; ++i, step = std::sqrt(step)) {
    const double middle = best;
    look(middle * step);
    look(middle / step);
  }
  return best;
}

}  // namespace piste
