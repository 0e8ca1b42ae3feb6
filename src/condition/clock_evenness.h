#pragma once
/// Whether the clock of the body IMU runs evenly, judged stretch by stretch beside the alignment of the whole log.

#include <string>
#include <vector>

#include "alignment_fit.h"
#include "paired_signals.h"
#include "piste/condition/time_sync.h"

namespace piste {

/// Refuses a clock that jumps by 0.3 to 20 s: stretches of 10 s whose rates correlate far better elsewhere in the log
/// than where the rough alignment x of the whole log puts them.
/// Throws DataError, of the log `name`, that says where.
void refuse_jumps(const SignalPair& signals, const FilteredPair& pair, const AlignmentState& x,
                  const std::string& name);

/// Offset of the clocks that each stretch of 10 s asks for beside the fit, one step of least squares on its residuals;
/// stretches that tell it to 3 ms or better.
std::vector<LocalOffset> local_offsets(const FilteredPair& pair, const AlignmentFit& fit);

/// What the local offsets scatter beyond their own noise, as 1-sigma [s]: the clock's own wander (the variance
/// component of DerSimonian and Laird 1986, Controlled Clinical Trials 7). 0 where noise explains them all.
/// Throws DataError, of the log `name`, where one offset stands out by 20 ms and 6 sigmas, or the wander exceeds 5 ms.
double clock_wander(const std::vector<LocalOffset>& local, const std::string& name);

}  // namespace piste
