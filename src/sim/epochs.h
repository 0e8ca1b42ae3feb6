#pragma once
// The times of simulated fixes.

#include <vector>

#include "piste/sim/truth.h"

namespace piste {

/// How many rows or fixes of this rate a duration [s] has.
inline std::size_t count_of(double duration, double rate) { return static_cast<std::size_t>(duration * rate + 1e-6); }

/// Times at which a source of this rate reports, from the start of the run to its end.
inline std::vector<double> epochs(const Truth& truth, double rate) {
  std::vector<double> times(count_of(truth.end_time() - truth.start_time(), rate) + 1);
  for (std::size_t k = 0; k < times.size(); ++k) times[k] = truth.start_time() + static_cast<double>(k) / rate;
  return times;
}

}  // namespace piste
