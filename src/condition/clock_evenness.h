#pragma once
/// Checks stretch by stretch that the clock of the body IMU runs evenly, relative to the alignment of the whole log.

#include <string>
#include <vector>

#include "alignment_fit.h"
#include "paired_signals.h"
#include "piste/condition/time_sync.h"

namespace piste {

/// Throws DataError, of the log `name`, if the clock jumps by 0.3 to 20 s. A jump shows in a stretch of 10 s whose
/// rates correlate far better at another place of the log than where the rough alignment x puts them. The error says
/// where.
void refuse_jumps(const SignalPair& signals, const FilteredPair& pair, const AlignmentState& x,
                  const std::string& name);

/// Offset of the clocks in each stretch of 10 s relative to the fit, by one step of least squares on the residuals of
/// the stretch. Only stretches that determine it to 3 ms or better are returned.
std::vector<LocalOffset> local_offsets(const FilteredPair& pair, const AlignmentFit& fit);

/// The wander of the clock, as 1-sigma [s]: the scatter of the local offsets about a line in excess of their own
/// noise (the variance component of DerSimonian and Laird 1986, Controlled Clinical Trials 7, given the two numbers of
/// the line: Thompson and Sharp 1999, Statistics in Medicine 18). It is 0 if noise explains all of it. Throws
/// DataError, of the log `name`, if one offset stands out by 20 ms and 6 sigmas, or if the wander exceeds 5 ms.
double clock_wander(const std::vector<LocalOffset>& local, const std::string& name);

}  // namespace piste
