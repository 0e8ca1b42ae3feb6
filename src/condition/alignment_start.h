#pragma once
/// Where the least squares of an alignment start: from the coarse offset and the angular rates alone.

#include <string>

#include "alignment_fit.h"
#include "paired_signals.h"

namespace piste {

/// The clock from the offset of the clocks' zeros [s], boresight, gyroscope bias and noise from the rates, the drifts'
/// knots every 5 s at zero, and the noise of the forces at 1 m/s².
/// Throws DataError, of the log `name`, where hardly any rates can be compared, or where an IMU is left-handed.
AlignmentFit start_alignment(const SignalPair& signals, const FilteredPair& pair, double coarse_offset,
                             const std::string& name);

}  // namespace piste
