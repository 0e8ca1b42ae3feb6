#pragma once
/// Chooses the samples for the fit of an alignment: those that both IMUs measured. Says which of them are in motion.

#include <vector>

#include "alignment_problem.h"
#include "paired_signals.h"

namespace piste {

/// Every stride-th sample of the body IMU, if the reference measured at its time too and the filters have settled. The
/// sigmas are not set yet.
std::vector<AlignmentEpoch> epochs_in_common(const SignalPair& signals, const FilteredPair& pair,
                                             const AlignmentState& x);

/// Sets `moving` where the rms rate of the reference within a second exceeds a fifth of its 95th percentile. Errors of
/// the models appear in motion, so the noise of the residuals is larger there than at rest.
void mark_motion(const FilteredPair& pair, const AlignmentState& x, std::vector<AlignmentEpoch>& epochs);

}  // namespace piste
