#pragma once
/// The noise of a run's sensors as numbers that a search may change: white noise and drift of both triads, how large
/// the errors of each receiver are beside the sigmas it states, and how long those of reference attitudes last.

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "piste/core/log.h"
#include "piste/core/options.h"
#include "piste/experiment/tune.h"

namespace piste {

/// One number of a noise model. The search sees its logarithm.
struct NoiseKnob {
  std::string name, unit;
  double factor;  ///< from SI to `unit`
  double width;   ///< 1-sigma of the logarithm about the value at the start, before any data
  std::function<double&(NoiseModel&)> at;
};

/// What `options` state: the model at the start of a search. `log` has the sigmas that the receivers state.
NoiseModel noise_model(const FilterOptions& options, const Log& log);

/// The numbers of `model` on which the run depends, by the blocks that it estimates and its sources.
std::vector<NoiseKnob> knobs_of(const NoiseModel& model, const FilterOptions& options, const Log& log);

/// The options, and the log's sigmas, as the model has them.
FilterOptions with_noise(FilterOptions options, const NoiseModel& model);
Log with_noise(Log log, const NoiseModel& model);

}  // namespace piste
