#pragma once
/// The causes that are tried, each a change of what the filter is told.

#include <functional>
#include <string>
#include <vector>

#include "piste/diagnosis/diagnose.h"
#include "piste/start/start.h"
#include "tune/evidence.h"

namespace piste {

/// What the filter is given.
struct Told {
  Log log;
  FilterOptions options;
  Start start;
};

/// A cause that was granted: by how much the log-likelihood of the innovations grew, the sentence about it, and how a
/// configuration states it.
using Granted = LikelierCause;
using Change = std::function<void(StatedModel&)>;

/// A cause: filters what the filter was told, changed, and says how much that gains over `base`.
using Cause = std::function<Granted(const Told& told, const Evidence& base, double end)>;

/// Noise of the IMU, sigmas of the fixes, antennas that sway and coloured errors, as far as the run has them. Their
/// likelihoods are to be compared with the delays held (tune/held_delays.h).
std::vector<Cause> searched_causes(const Told& told);

/// The antenna of a receiver moves on the body.
Cause swaying_antenna(std::size_t receiver);
/// Whether that is a cause for a receiver of the run.
bool may_sway(const FilterOptions& options, std::size_t receiver);

/// Delays, lever arm, biases and scales, likewise. Where the lever arm is told so large that no start can be right, the
/// start is found anew with `heading`.
std::vector<Cause> constant_causes(const Told& told, const InitialHeading& heading);

/// A clock that drifts.
std::vector<Cause> clock_causes(const Told& told);

/// A heading at the start that was stated, or taken from the magnetometer, and contradicts the motion; two antennas
/// whose baseline points elsewhere, for which the start is found anew with `heading`.
std::vector<Cause> heading_causes(const Told& told, const InitialHeading& heading);

/// What the motion itself tells (inspect/log_match.h): another assignment of gyroscopes or of the whole IMU, and a
/// clock that is off by more than the delay of the fixes can be. The start is found anew with `heading`.
std::vector<Cause> motion_causes(const Told& told, const InitialHeading& heading);

}  // namespace piste
