#pragma once
/// Estimates biases and scales by the GPS/MEMS filter, with six error models.

#include <vector>

#include "piste/core/log.h"
#include "piste/core/options.h"
#include "piste/study/study_findings.h"

namespace piste {

/// The input of the filter for one run of an IMU.
struct FilterCase {
  Log log;                ///< with its rests marked
  FilterOptions options;  ///< sensor, receivers and reference attitude; `estimate` is not used
  Interval run;           ///< the interval over which estimates are averaged
};

/// Estimates by all models. The bias is a random constant alone (kConstant…), or has in addition a random walk (kWalk…)
/// or a first-order Gauss-Markov process (kMarkov…) with the drift of the sensor file. If that file has the other kind
/// of process, it is converted: a Gauss-Markov process becomes a walk of density √(2σ²/τ). A walk becomes a
/// Gauss-Markov process whose correlation time is a hundred times the run. Scales are random constants.
///
/// Each model is filtered and smoothed, without the reference attitude (with a heading estimated from the motion), and
/// with it if there is one. Values are means over the run of bias + drift and of scale. Their covariances are means
/// too, because errors within a run are correlated.
///
/// An impossible estimate, such as one of a run without motion at the start, is left out; its reason is appended to
/// `warnings`.
std::vector<MethodEstimate> filter_estimates(const FilterCase& of, std::vector<std::string>& warnings);

}  // namespace piste
