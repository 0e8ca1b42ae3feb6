#include "experiment/innovation_likelihood.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

namespace piste {

double log_likelihood(const Innovation& innovation) {
  constexpr double kSpoilt = 0.01, kWider = 5;  // part of the innovations that is, and how many times wider it is
  const double good = std::log(1 - kSpoilt) - 0.5 * innovation.nis;
  const double spoilt =
      std::log(kSpoilt) - innovation.dof * std::log(kWider) - 0.5 * innovation.nis / (kWider * kWider);
  const double larger = std::max(good, spoilt);
  return larger + std::log1p(std::exp(std::min(good, spoilt) - larger)) - 0.5 * innovation.log_determinant;
}

std::vector<Innovation> telling(const Solution& solution, double start, const std::vector<Interval>& rest) {
  constexpr double kSettled = 15;  // s
  std::vector<Innovation> kept;
  for (const Innovation& i : solution.innovations) {
    const std::string& source = solution.sources[static_cast<std::size_t>(i.source)];
    if (!source.starts_with("gnss") && !source.starts_with("attitude")) continue;
    if (i.outcome == Outcome::kRepeated || i.time < start + kSettled) continue;
    const bool still = std::any_of(rest.begin(), rest.end(), [&](const Interval& r) { return r.contains(i.time); });
    if (!still) kept.push_back(i);
  }
  return kept;
}

double log_likelihood(const std::vector<Innovation>& innovations) {
  if (innovations.empty()) return -std::numeric_limits<double>::infinity();
  double sum = 0;
  for (const Innovation& i : innovations) sum += log_likelihood(i);
  return sum;
}

}  // namespace piste
