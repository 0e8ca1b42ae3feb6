#pragma once
/// Ramp faults of a receiver: its positions run away from its own velocities, each step too small to be seen as a jump.

#include <vector>

#include "piste/core/behaviour.h"
#include "piste/core/log.h"

namespace piste {

/// Excludes the positions of ramp faults (GnssFix::runs_away), and returns the faults in the order of time.
///
/// Positions and velocities are compared by what a track by the velocities alone leaves of the positions,
///
///     S_k = p_k − Σ ½ (v_i + v_{i−1}) (t_i − t_{i−1}) − τ v_k − κ a_k
///
/// with the velocities' delay τ, and κ of their change a, by least absolute deviations: κ is τ²/2 and what trapezoids
/// leave. Without a fault, S_k − S_i has the errors of two positions, and those of the velocities between. A fault is a
/// change of S over a window of 1 to 128 s, with the following properties:
///
/// - Chance does not explain it: it exceeds what one honest log in a million reaches in any of its windows (the
///   Bonferroni bound of the χ² distribution). Its variance is the stated one, or the log's own, if the median of
///   all windows shows more.
/// - No step within it exceeds that bound: jumps are left to the filter (FaultDetection).
/// - S returns to where it was, within `distrust` seconds. An error of the velocities would leave it elsewhere. Who is
///   at fault in a ramp that does not return is not known, and it is left to the filter.
///
/// The fault begins at the earliest time that the positions before its detection allow (95 %), by least squares of a
/// level and a ramp. `options`: `gate`, `distrust`, `recent` (a longer step between fixes ends a comparison) and
/// `readmit_after` (so many fixes in a row that have returned end the fault). `world`: that of the fixes. Receivers
/// without velocities are not tested. Source: Bhatti, Ochieng and Feng 2007, of slowly growing errors; they test the
/// innovations of a filter, and here the velocities of the receiver stand for it.
///
/// Example: positions that run away by 0.1 m/s for 30 s, with velocities of 3 cm/s, are excluded from about the first
/// second to the last.
std::vector<RampFault> exclude_ramp_faults(std::vector<GnssFix>& fixes, const FaultDetectionOptions& options,
                                           const World& world);

}  // namespace piste
