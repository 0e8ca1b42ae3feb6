#pragma once
/// One clock, one boresight, one lever arm for two IMUs on one plate, from their own signals. In piste::batch.
///
/// The offset of the clocks is found first, without any prior, as the peak of the normalised cross-correlation of the
/// norms of the angular rates, which no mounting changes. Then one least-squares problem is solved over everything that
/// makes two rigidly mounted IMUs differ, where t is the time of the reference and m the clock of the body IMU:
///
///     t   = m − offset − drift (m − first m)
///     w_b = (1 + gyro_scale)  R_rbᵀ w_r(t)                                    + gyro_bias  + gyro_drift(m)  + noise
///     f_b = (1 + accel_scale) R_rbᵀ (f_r + w_r' × p_rb_r + w_r × (w_r × p_rb_r)) + accel_bias + accel_drift(m) + noise
///
/// Both signals are means over the same intervals and pass the same zero-phase low-pass; the reference is interpolated
/// by a cubic spline, the body IMU never is. The residuals are whitened by an autoregression fitted to them, so that
/// the covariance is that of the noise as it is. The in-run drifts are states at knots, with the sensor's process
/// between them; the scales have the sensor's sigma as prior; all else is free.
///
/// What the motion does not determine is named in Alignment::undetermined, and its sigmas are infinite.

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

/// Aligns the body IMU with the reference. The samples are as `condition_imu` gives them, each log on its own clock.
/// Throws ConfigError where the low-pass is not below half of both rates, and DataError where there is no one answer:
/// where the logs are shorter than 5 s, hold no motion in common or a motion that repeats itself, where a clock jumps
/// or is wrong by more than a hundredth, or where an IMU is left-handed. The message says which, and where in the log.
Alignment align(const std::vector<ImuSample>& body, const std::vector<ImuSample>& reference,
                const AlignmentOptions& options);

/// Both signals, unfiltered, after the alignment: the reference at the samples of the body IMU, on one clock, turned
/// into body axes and moved to the body IMU. Components of the lever arm that are not determined are taken for zero.
AlignedImus bring_together(const std::vector<ImuSample>& body, const std::vector<ImuSample>& reference,
                           const Alignment& alignment);

}  // namespace piste
