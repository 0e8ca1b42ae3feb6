#pragma once
/// Fuses the recordings of several IMUs on one body to the samples of one, and computes their parities.

#include "piste/core/log.h"
#include "piste/core/options.h"

namespace piste {

/// Conditions each IMU by itself, resamples all at the epochs of the first, and moves their specific forces to its
/// place. Then it takes the weighted mean without clipped, stuck, spiky, missing or faulty samples
/// (condition/imu_differences.h). The samples are those of the mean; where IMUs are missing, the noise that this adds
/// is in `interpolated`. The differences are in `parity`, the exclusions in `counts.imus`. @pre options.imus has one
/// entry for each recording, the first as well. Throws as condition_imu().
Log condition_imus(const Recording& recording, const ConditioningOptions& options);

}  // namespace piste
