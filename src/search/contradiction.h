#pragma once
/// Whether what the whole log shows contradicts itself: the clock, the velocities, or the vehicle.

#include "piste/inspect/inspection.h"
#include "search/whole_log.h"

namespace piste {

/// Whether the clock drifts by no more than clocks do.
bool drifts_plausibly(const Calibration& found);

/// Whether the receiver's velocities contradict its positions over the whole log: without them the filter would have
/// the antenna, the clock, or a slow error of the positions elsewhere by many of its sigmas. Velocities that a receiver
/// smooths by a model of its own do so, and no delay mends them. A clock that drifts by more than any clock does counts
/// too. False without velocities, and where positions alone determine little. (Of two estimates the one that presumes
/// less is trusted: Hausman, "Specification tests in econometrics", 1978.)
bool velocities_contradict(WholeLog log, const Calibration& found, const ProgressCallback& progress = {});

/// Whether the constraint of a vehicle contradicts the fixes over the whole log: with it the filter would have the
/// scales, or a slow error of the positions, elsewhere by many of the sigmas that it has without. A body that sways on
/// what carries it, and does not lean, is no vehicle: the constraint makes its rotations smaller.
/// @pre `log.vehicle` is there.
bool vehicle_contradicts(WholeLog log, const Calibration& found, const ProgressCallback& progress = {});

/// What both cost, in rows of the IMU that are filtered once.
double cost_of_contradiction(const WholeLog& log);

}  // namespace piste
