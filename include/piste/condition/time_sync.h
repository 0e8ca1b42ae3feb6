#pragma once
/// Aligns two IMUs on one plate: estimates the offset and drift of their clocks, the boresight and the lever arm from
/// their signals alone. It is part of piste::batch. docs/alignment.md is an introduction.
///
/// First the offset of the clocks is estimated, without a first guess, as the peak of the normalised cross-correlation
/// of the norms of the angular rates. The norm does not depend on the mounting. Then one least-squares problem is
/// solved for all parameters in which two rigidly mounted IMUs differ. With t the time of the reference and m the clock
/// of the body IMU:
///
///     t   = m − offset − drift (m − first m)
///     w_b = (1 + gyro_scale)  R_rbᵀ w_r(t)                                    + gyro_bias  + gyro_drift(m)  + noise
///     f_b = (1 + accel_scale) R_rbᵀ (f_r + w_r' × p_rb_r + w_r × (w_r × p_rb_r)) + accel_bias + accel_drift(m) + noise
///
/// Both signals are means over the same intervals and go through the same zero-phase low-pass. The reference is
/// interpolated by a cubic spline; the body IMU is never interpolated. The residuals are whitened by an autoregression
/// that is fitted to them, so that the covariance is right for the noise as it is. The in-run drifts are estimated at
/// knots, and between knots follow the sensor's process. The scales have the sensor's sigma as prior. All else has no
/// prior.
///
/// Parameters that the motion does not determine are named in Alignment::undetermined, and their sigmas are infinite.

#include <string>
#include <vector>

#include "piste/condition/alignment.h"
#include "piste/core/aligned.h"
#include "piste/core/sensor.h"

namespace piste {

/// Options of an alignment.
struct AlignmentOptions {
  ImuSensor sensor;          ///< the body IMU, whose scale sigmas and drift processes are used
  ImuSensor reference = {};  ///< the reference, whose noise must not be taken for motion
  double low_pass = 0;       ///< of both signals [Hz]; 0 = 12 Hz, or 0.4 of the slower rate if that is less
  std::string name = {};     ///< name of the body IMU's log, for errors
};

/// Aligns the body IMU with the reference. @pre Samples are those of `condition_imu`; each log has its own clock.
/// Throws ConfigError if the low-pass is not below half of both rates. Throws DataError if there is no unique answer:
/// the logs are shorter than 5 s, they have no common motion, or the motion repeats itself. It also throws if a clock
/// jumps, its rate is wrong by more than 1 %, or an IMU is left-handed. The message says which, and where in the log.
Alignment align(const std::vector<ImuSample>& body, const std::vector<ImuSample>& reference,
                const AlignmentOptions& options);

/// Applies an alignment. Returns both signals, not filtered, at the sample times of the body IMU and on one clock. The
/// reference is turned into body axes and moved to the body IMU. Undetermined components of the lever arm are taken to
/// be zero.
AlignedImus bring_together(const std::vector<ImuSample>& body, const std::vector<ImuSample>& reference,
                           const Alignment& alignment);

}  // namespace piste
