#pragma once
/// Biases and scales as the GPS/MEMS filter tells them, by six models.

#include <vector>

#include "piste/core/log.h"
#include "piste/core/options.h"
#include "piste/experiment/study_findings.h"

namespace piste {

/// What a filter is told of one run of an IMU.
struct FilterCase {
  Log log;                ///< with its rests marked
  FilterOptions options;  ///< sensor, receivers and reference attitude; not what is estimated
  Interval run;           ///< over which estimates are averaged
};

/// Turn-on constants as random constants (kConstant…), with a random walk (kWalk…) or a first-order Gauss-Markov
/// process (kMarkov…) on top, as the sensor file's drift has it; a walk has the density √(2σ²/τ) of a Gauss-Markov
/// process, and the other way round a walk becomes one that lasts a hundred times longer than the run. Scales are
/// random constants. Filtered and smoothed; without the reference attitude, with a heading found from the motion, and
/// with it, where the case has one. Values are means over the run of bias + drift and of scale, and so are their
/// covariances, as errors within a run go together.
///
/// What cannot be had, such as a start without motion, is left out, and its reason appended to `warnings`.
std::vector<MethodEstimate> filter_estimates(const FilterCase& of, std::vector<std::string>& warnings);

}  // namespace piste
