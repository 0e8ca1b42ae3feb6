#pragma once
/// The noise of a run's sensors as numbers that a search may change: white noise and drift of both triads, how large
/// the errors of each receiver are relative to the sigmas it states, and how long those of reference attitudes last.

#include <cmath>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "piste/core/log.h"
#include "piste/core/options.h"
#include "piste/tune/likeliest_noise.h"
#include "tune/white_noise_range.h"

namespace piste {

/// How far a size and a time may be from the value at the start, as the 1-sigma of its logarithm.
inline const double kSizeWidth = std::log(10), kTimeWidth = std::log(3);

/// One number of a noise model. The search sees its logarithm.
struct NoiseKnob {
  std::string name, unit;
  double factor;  ///< from SI to `unit`
  double width;   ///< 1-sigma of the logarithm about the value at the start, before any data
  double most;    ///< largest value that is possible, in SI
  std::function<double&(NoiseModel&)> at;
  double least = 0;  ///< likewise the smallest
};

/// What `options` state: the model at the start of a search. `log` has the sigmas that the receivers state.
NoiseModel noise_model(const FilterOptions& options, const Log& log);

/// The numbers of `model` on which the run depends, by the blocks that it estimates and its sources; `white`
/// has the limits of the IMU's white noise.
std::vector<NoiseKnob> knobs_of(const NoiseModel& model, const FilterOptions& options, const Log& log,
                                const WhiteNoiseRange& white);

/// The options, and the log's sigmas, as the model has them.
FilterOptions with_noise(FilterOptions options, const NoiseModel& model);
Log with_noise(Log log, const NoiseModel& model);

}  // namespace piste
