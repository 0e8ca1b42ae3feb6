#pragma once
/// Computes the reference solution of a run from a tactical IMU and a carrier-phase receiver, filtered and smoothed.

#include <optional>
#include <vector>

#include "piste/study/reference_track.h"
#include "piste/study/study_config.h"

namespace piste {

struct ReferenceSolution {
  /// The attitude as measurements for a GPS/MEMS filter: fixes at 10 Hz, and the correlation time of their errors [s].
  AttitudeRecording attitude;
  double correlation_time = 0;
  ReferenceTrack track;
  Vector3d sigma_attitude;    ///< rms over the log: roll, pitch, heading
  double sigma_position = 0;  ///< rms over the log, of three axes
};

/// The solution from the recordings of a reference IMU and its receiver, with the IMU error model of the sensor file.
/// Throws DataError if the log cannot be replayed.
ReferenceSolution solve_reference(const RunConfig& run, const ImuRecording& imu, const GnssRecording& gnss);

}  // namespace piste
