#pragma once
/// Which samples an alignment explains: those that both IMUs measured, and which of them are in motion.

#include <vector>

#include "alignment_problem.h"
#include "paired_signals.h"

namespace piste {

/// Samples of the body IMU, one every stride, at which the reference measured too and the filters have settled. Their
/// sigmas are not set yet.
std::vector<AlignmentEpoch> epochs_in_common(const SignalPair& signals, const FilteredPair& pair,
                                             const AlignmentState& x);

/// Sets `moving` where the rms rate of the reference within a second exceeds a fifth of its 95th percentile. The models
/// fail first in motion, so that the noise there is not the noise at rest.
void mark_motion(const FilteredPair& pair, const AlignmentState& x, std::vector<AlignmentEpoch>& epochs);

}  // namespace piste
