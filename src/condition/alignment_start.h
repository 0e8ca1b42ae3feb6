#pragma once
/// Start values for the least squares of an alignment, from the coarse offset and the angular rates.

#include <string>

#include "alignment_fit.h"
#include "paired_signals.h"

namespace piste {

/// Start values: the clock from the offset between the zeros of the two clocks [s]; boresight, gyroscope bias and noise
/// from the rates; drifts of zero at knots every 5 s; and 1 m/s² for the noise of the forces.
/// Throws DataError, of the log `name`, if hardly any rates can be compared, or if an IMU is left-handed.
AlignmentFit start_alignment(const SignalPair& signals, const FilteredPair& pair, double coarse_offset,
                             const std::string& name);

}  // namespace piste
