#pragma once
/// One clock, one boresight, one lever arm for two IMUs on one plate, from their own signals. In piste::batch.
///
/// First the offset of the clocks without any prior: the peak of the normalised cross-correlation of the norms of the
/// angular rates, which no mounting changes. Then one least-squares problem over everything that makes two rigidly
/// mounted IMUs differ, t being the time of the reference and m the clock of the body IMU:
///
///     t   = m − offset − drift (m − first m)
///     w_b = (1 + gyro_scale)  R_rbᵀ w_r(t)                                    + gyro_bias  + gyro_drift(m)  + noise
///     f_b = (1 + accel_scale) R_rbᵀ (f_r + w_r' × p_rb_r + w_r × (w_r × p_rb_r)) + accel_bias + accel_drift(m) + noise
///
/// Both signals are means over the same intervals and went through the same zero-phase low-pass; the reference is
/// interpolated by a cubic spline, the body IMU never. What is left is whitened by an autoregression fitted to it, so
/// that the covariance is that of the noise as it is. The in-run drifts are states at knots with the sensor's process
/// between them; scales have the sensor's sigma as prior; all else is free.
///
/// What the motion does not determine is said: it stands in Alignment::undetermined, and its sigmas are infinite.

#include <string>
#include <vector>

#include "piste/condition/alignment.h"
#include "piste/core/aligned.h"
#include "piste/core/sensor.h"

namespace piste {

struct AlignmentOptions {
  ImuSensor sensor;          ///< of the body IMU: scale priors, drift processes
  ImuSensor reference = {};  ///< its noise, which is not to be taken for motion
  double low_pass = 0;       ///< [Hz] of both signals; 0 = 12 Hz, or 0.4 of the slower rate where that is less
  std::string name = {};     ///< of the body IMU's log, for errors
};

/// Aligns the body IMU with the reference. Samples as `condition_imu` gives them, each on its own clock.
/// Throws DataError where there is no one answer: no motion, no common motion, a clock that jumps or is wrong by more
/// than a thousandth, a motion that repeats itself; the message says which, and where.
Alignment align(const std::vector<ImuSample>& body, const std::vector<ImuSample>& reference,
                const AlignmentOptions& options);

/// Both signals, unfiltered, after the alignment, with its known_lever_arm().
AlignedImus bring_together(const std::vector<ImuSample>& body, const std::vector<ImuSample>& reference,
                           const Alignment& alignment);

}  // namespace piste
