#pragma once
/// What an alignment found, as text. The same alignment gives the same bytes.

#include <string>

#include "piste/condition/time_sync.h"

namespace piste {

/// `alignment.json`: clock_offset_s at the first sample, clock_drift_ppm, boresight_deg (roll, pitch, heading of R_rb),
/// lever_arm_m (r → b, in r), their sigmas under `sigma_…`; then biases and scales of the body IMU, what was not
/// determined, warnings, and how well the signals agree. What is not determined is null.
std::string alignment_json(const Alignment& alignment);

/// 1-sigma [rad] of roll, pitch and heading of R_rb; infinite for an angle that an undetermined rotation turns.
Vector3d boresight_sigma(const Alignment& alignment);

/// A few lines for a terminal: offset, drift, boresight and lever arm with their sigmas, and what is to be known.
std::string alignment_text(const Alignment& alignment);

/// `aligned.csv`: both IMUs at the samples of the body IMU, GPS time; the reference turned into b and moved there.
/// Columns as of an imu log, those of the reference with `reference_` before; `usable` is 0 where one of the two is
/// silent or clipped.
std::string aligned_csv(const AlignedImus& imus);

}  // namespace piste
