#pragma once
/// The search for the maximum-likelihood factor of a value, such as a noise.

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <map>

namespace piste {

inline constexpr double kFactorStep = 3;
inline constexpr int kMostFactorSteps = 8;

/// A factor, and by how much the log-likelihood grows with it.
struct Factor {
  double value = 1, gain = 0;
};

/// The maximum-likelihood factor of a value, and its gain. The search takes steps of a factor of 3 up and down while
/// they gain, then of its root. Then it takes the top of the parabola through the best three over the logarithm of the
/// factor, twice. Of values of equal likelihood, such as a noise below all that can be seen, it is the one nearest to
/// the file's. `gain(factor)` filters the log; it is called once for each factor.
template <class Gain>
Factor most_likely_factor(Gain&& gain) {
  std::map<double, double> tried{{0, 0}};  // gain by the number of steps
  const auto most = [&] { return std::ranges::max_element(tried, {}, [](const auto& t) { return t.second; })->second; };
  const auto best = [&] {
    constexpr double kAsLikely = 1;  // of the log-likelihood
    const double least = most() - kAsLikely;
    return std::ranges::min_element(tried, {}, [least](const auto& t) {
      return t.second < least ? std::numeric_limits<double>::infinity() : std::abs(t.first);
    });
  };
  const auto attempt = [&](double steps) {
    const auto known = tried.find(steps);
    return known != tried.end() ? known->second : tried[steps] = gain(std::pow(kFactorStep, steps));
  };
  for (const int direction : {1, -1}) {
    // One step that gains nothing may lead to one that does, as where all fixes are rejected.
    for (int steps = 1, missed = 0; steps <= kMostFactorSteps && missed < 2; ++steps) {
      const double top = most();
      missed = attempt(direction * steps) > top ? 0 : missed + 1;
    }
    if (most() > 0) break;
  }
  if (most() <= 0) return {};
  const double middle = best()->first;
  attempt(middle + 0.5);
  attempt(middle - 0.5);
  for (int parabola = 0; parabola < 2; ++parabola) {  // through the best and its neighbours
    const auto top = tried.find(best()->first);
    if (top == tried.begin() || std::next(top) == tried.end()) break;
    const auto [low, at_low] = *std::prev(top);
    const auto [high, at_high] = *std::next(top);
    const double rise = (top->second - at_low) / (top->first - low),
                 fall = (at_high - top->second) / (high - top->first), curvature = (fall - rise) / (high - low);
    if (!(curvature < 0) || !std::isfinite(curvature)) break;
    attempt(std::clamp((low + top->first) / 2 - rise / (2 * curvature), low, high));
  }
  return {std::pow(kFactorStep, best()->first), best()->second};
}

}  // namespace piste
