#pragma once
/// The reference of a run: a tactical IMU and a carrier-phase receiver, filtered and smoothed.

#include <optional>
#include <vector>

#include "piste/experiment/reference_track.h"
#include "piste/experiment/study_config.h"

namespace piste {

struct ReferenceSolution {
  /// What a GPS/MEMS filter takes as measurements: fixes at 10 Hz, and how long their errors last [s].
  AttitudeRecording attitude;
  double correlation_time = 0;
  ReferenceTrack track;
  Vector3d sigma_attitude;    ///< rms over the log: roll, pitch, heading
  double sigma_position = 0;  ///< rms over the log, of three axes
};

/// Of a reference IMU's recording and that of its receiver; its own error model is that of its sensor file.
/// Throws DataError where the log cannot be navigated.
ReferenceSolution solve_reference(const RunConfig& run, const ImuRecording& imu, const GnssRecording& gnss);

}  // namespace piste
