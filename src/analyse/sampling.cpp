#include "piste/analyse/sampling.h"

#include <cmath>
#include <numeric>

#include "piste/math/statistics.h"

namespace piste {
namespace {

constexpr double kGapFactor = 1.5;
constexpr double kFinest = 1e-6;  // s

// What all times, counted from the first, are multiples of; 0 where that is finer than kFinest.
double resolution(std::span<const double> time) {
  long long common = 0;
  for (const double t : time) {
    const double steps = (t - time.front()) / kFinest;
    if (std::abs(steps - std::round(steps)) > 0.1 || steps > 9e15) return 0;
    common = std::gcd(common, std::llround(steps));
    if (common == 1) break;
  }
  return kFinest * static_cast<double>(common);
}

}  // namespace

Sampling sampling(std::span<const double> time) {
  Sampling s;
  s.rows = time.size();
  if (time.empty()) return s;
  s.span = {time.front(), time.back()};
  if (time.size() < 2) return s;
  std::vector<double> steps(time.size() - 1);
  for (std::size_t i = 0; i < steps.size(); ++i) steps[i] = time[i + 1] - time[i];
  s.interval = median(steps);
  s.resolution = resolution(time);
  double sum = 0;
  std::size_t count = 0;
  const double both = (kGapFactor + 1) * s.interval;
  for (std::size_t i = 0; i < steps.size(); ++i) {
    const bool late =
        (i > 0 && steps[i] + steps[i - 1] < both) || (i + 1 < steps.size() && steps[i] + steps[i + 1] < both);
    if (steps[i] > kGapFactor * s.interval && !late) {
      s.gaps.push_back({time[i], time[i + 1]});
      s.missing += static_cast<std::size_t>(std::llround(std::min(steps[i] / s.interval, 1e15))) - 1;
      continue;
    }
    sum += (steps[i] - s.interval) * (steps[i] - s.interval);
    ++count;
  }
  if (count > 0) s.jitter = std::sqrt(sum / static_cast<double>(count));
  return s;
}

}  // namespace piste
