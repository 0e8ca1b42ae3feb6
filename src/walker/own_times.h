#pragma once
// Fixes at the times where they belong by the known delays of their source, for what looks at a log before the filter
// runs. The filter itself takes each part of a fix at its own time.

#include <vector>

#include "piste/core/log.h"
#include "piste/core/options.h"

namespace piste {

/// Fixes of a receiver, with the time of their positions, or of their velocities where only these are used. If the
/// delays of both differ, the velocities are interpolated at that time; a fix has none where its neighbours are too far
/// apart or have none.
std::vector<GnssFix> at_own_times(std::vector<GnssFix> fixes, const GnssOptions& receiver);

/// Fixes of a reference attitude.
std::vector<AttitudeFix> at_own_times(std::vector<AttitudeFix> fixes, const AttitudeOptions& reference);

}  // namespace piste
