#pragma once
/// From the recordings of several IMUs on one body to the samples of one, and the parities of all.

#include "piste/core/log.h"
#include "piste/core/options.h"

namespace piste {

/// Conditions each unit by itself, brings all to the epochs of the first, moves their specific forces to its place, and
/// takes the weighted mean without what is clipped, stuck, spikes, silent or wrong (condition/unit_differences.h). The
/// samples are those of the mean, with its noise where units are missing as `mended`; `parity` and `counts.units` tell
/// the rest. @pre options.units has one entry for each recording, the first as well. Throws as condition_imu().
Log condition_units(const Recording& recording, const ConditioningOptions& options);

}  // namespace piste
