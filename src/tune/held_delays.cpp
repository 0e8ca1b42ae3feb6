#include "tune/held_delays.h"

#include <algorithm>
#include <array>

namespace piste {

Start with_delays(Start start, const Estimate& estimated) {
  start.x.gnss_delay = estimated.gnss_delay;
  start.x.velocity_delay = estimated.velocity_delay;
  start.x.attitude_delay = estimated.attitude_delay;
  start.x.clock_drift = estimated.clock_drift;
  return start;
}

FilterOptions holding_delays(FilterOptions options) {
  constexpr double kHeld = 1e-7, kHeldDrift = 1e-11;  // s; a ratio
  Priors& priors = options.priors;
  for (double* prior : {&priors.gnss_delay, &priors.velocity_delay, &priors.attitude_delay}) {
    *prior = std::min(*prior, kHeld);
  }
  priors.clock_drift = std::min(priors.clock_drift, kHeldDrift);
  return options;
}

bool estimates_delays(const FilterOptions& options) {
  constexpr std::array kDelays{Block::kGnssDelay, Block::kVelocityDelay, Block::kAttitudeDelay, Block::kClockDrift};
  return std::ranges::any_of(kDelays, [&](Block block) { return options.estimates(block); });
}

}  // namespace piste
