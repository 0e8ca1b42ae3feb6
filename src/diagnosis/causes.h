#pragma once
/// The causes that are tested, each a change of the input of the filter.

#include <functional>
#include <string>
#include <vector>

#include "piste/diagnosis/diagnose.h"
#include "piste/start/start.h"
#include "tune/evidence.h"

namespace piste {

/// The input of the filter.
struct FilterInput {
  Log log;
  FilterOptions options;
  Start start;
};

/// A tested cause: the gain of the log-likelihood of the innovations, the sentence about it, and how a configuration
/// states it.
using TestedCause = LikelierCause;
using Change = std::function<void(StatedModel&)>;

/// A cause: filters the changed input and returns its gain over `base`, the run without the cause.
using Cause = std::function<TestedCause(const FilterInput& input, const Evidence& base, double end)>;

/// Noise of the IMU, sigmas of the fixes, antennas that sway and coloured errors, each where the run has it. Their
/// likelihoods are to be compared with the delays held (tune/held_delays.h).
std::vector<Cause> searched_causes(const FilterInput& input);

/// The antenna of a receiver moves on the body.
Cause swaying_antenna(std::size_t receiver);
/// Whether that is a cause for a receiver of the run.
bool may_sway(const FilterOptions& options, std::size_t receiver);

/// Delays, lever arm, biases and scales, each where the run has it. Where the configured lever arm is so long that no
/// start can be right, the start is estimated again with `heading`.
std::vector<Cause> constant_causes(const FilterInput& input, const InitialHeading& heading);

/// A clock that drifts.
std::vector<Cause> clock_causes(const FilterInput& input);

/// A heading at the start that was stated, or taken from the magnetometer, and contradicts the motion; two antennas
/// whose baseline points elsewhere, for which the start is estimated again with `heading`.
std::vector<Cause> heading_causes(const FilterInput& input, const InitialHeading& heading);

/// Causes that the motion shows (inspect/log_match.h): other axes of the gyroscopes or of the whole IMU, and a clock
/// that is off by more than the delay of the fixes can be. The start is estimated again with `heading`.
std::vector<Cause> motion_causes(const FilterInput& input, const InitialHeading& heading);

}  // namespace piste
