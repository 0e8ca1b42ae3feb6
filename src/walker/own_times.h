#pragma once
// Fixes at their times of validity, by the known delays of their source, for code that reads a log before the filter
// runs. The filter itself takes each channel of a fix at its own time.

#include <vector>

#include "piste/core/log.h"
#include "piste/core/options.h"

namespace piste {

/// Fixes of a receiver at the times of validity of their positions, or of their velocities where only these are used.
/// If the two delays differ, the velocities are interpolated to that time. A fix has no velocity where its neighbours
/// are too far apart or have none.
std::vector<GnssFix> at_own_times(std::vector<GnssFix> fixes, const GnssOptions& receiver);

/// Fixes of a reference attitude at their times of validity.
std::vector<AttitudeFix> at_own_times(std::vector<AttitudeFix> fixes, const AttitudeOptions& reference);

}  // namespace piste
