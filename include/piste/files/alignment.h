#pragma once
/// The files of an alignment: `alignment.json`, and both signals in `aligned.csv`. Equal alignments give equal bytes.

#include <string>

#include "piste/condition/alignment.h"
#include "piste/core/aligned.h"

namespace piste {

/// `alignment.json`: clock_offset_s at the first sample, clock_drift_ppm, boresight_deg (roll, pitch, heading of R_rb),
/// lever_arm_m (from r to b, in r), and their sigmas as `sigma_…`; then biases and scales of the body IMU, a list of
/// undetermined quantities, warnings, and the agreement of the signals. An undetermined quantity is null.
std::string alignment_json(const Alignment& alignment);

/// `aligned.csv`: both IMUs at the sample times of the body IMU, in GPS time. The reference is turned into b and
/// transferred there. The columns are those of an imu log; the reference's have the prefix `reference_`. `usable` is 0
/// where one of the two has no sample or the body IMU clips.
std::string aligned_csv(const AlignedImus& imus);

}  // namespace piste
