#pragma once
/// What an alignment found, as files: `alignment.json`, and both signals in `aligned.csv`. The same alignment gives the
/// same bytes.

#include <string>

#include "piste/condition/alignment.h"
#include "piste/core/aligned.h"

namespace piste {

/// `alignment.json`: clock_offset_s at the first sample, clock_drift_ppm, boresight_deg (roll, pitch, heading of R_rb),
/// lever_arm_m (r → b, in r), their sigmas under `sigma_…`; then biases and scales of the body IMU, what was not
/// determined, warnings, and how well the signals agree. What is not determined is null.
std::string alignment_json(const Alignment& alignment);

/// `aligned.csv`: both IMUs at the samples of the body IMU, GPS time; the reference turned into b and moved there.
/// Columns as of an imu log, those of the reference with `reference_` before; `usable` is 0 where one of the two is
/// silent or clipped.
std::string aligned_csv(const AlignedImus& imus);

}  // namespace piste
