// A clock that drifts as the cause: its rate is searched for, with an offset that the run may find.

#include <fmt/format.h>

#include <algorithm>

#include "diagnosis/cause_support.h"

namespace piste {
namespace {

// A drift is a mean in a linear model, so that the log-likelihood is a parabola in it: three values give its top.
Cause clock_drift(Interval span) {
  return [span](const FilterInput& input, const Evidence& base, double end) {
    constexpr double kFirst = 0.1;  // s over the span
    constexpr int kRounds = 3;
    const double length = span.end - span.start;
    const auto attempt = [&](double rate) {
      FilterInput changed = input;
      move_fixes(changed.log, [&](double time) { return rate * (time - span.start); });
      want(changed.options, Block::kGnssDelay);
      changed.options.priors.gnss_delay = kWideClock;
      return lasting_gain(filter_again(changed.log, changed.options, input.start, end), base);
    };
    const double steady = attempt(0);
    double rate = 0, step = kFirst / length, top = steady;
    // A drift holds an offset in it: it must explain more than that.
    constexpr double kMore = 15, kPartMore = 0.03, kPerMillion = 1e6;
    for (int round = 0; round < kRounds; ++round, step /= 4) {
      const double low = attempt(rate - step), high = attempt(rate + step), curvature = low + high - 2 * top;
      const double slope = high - low, nearer = slope > 0 ? step : -step;
      if (curvature < 0) {
        if (top - slope * slope / (8 * curvature) - steady < kMore) return TestedCause{};
        const double move = std::clamp(-0.5 * step * slope / curvature, -2 * step, 2 * step);
        if (const double there = attempt(rate + move); there > std::max({top, low, high})) {
          top = there;
          rate += move;
          continue;
        }
      }
      if (std::max(low, high) > top) {
        top = std::max(low, high);
        rate += nearer;
      }
    }
    if (top - steady < std::max(kMore, kPartMore * top)) return TestedCause{};
    return searched(top, fmt::format("clock drift of the IMU ({:+.0f} ppm more than the file's)", rate * kPerMillion),
                    [rate](StatedModel& m) { m.clock_drift += rate; });
  };
}

}  // namespace

std::vector<Cause> clock_causes(const FilterInput& input) {
  if (!some_positions(input.options) || input.log.gnss.front().size() < 2) return {};
  return {clock_drift({input.log.gnss.front().front().time, input.log.gnss.front().back().time})};
}

}  // namespace piste
