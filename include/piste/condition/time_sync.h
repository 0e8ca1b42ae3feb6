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
/// What the motion does not determine is named in `undetermined`, and its sigmas are infinite.

#include <Eigen/Core>
#include <cmath>
#include <string>
#include <vector>

#include "piste/core/aligned.h"
#include "piste/core/sensor.h"
#include "piste/math/so3.h"

namespace piste {

/// Where the parameters stand in the covariance of an alignment.
struct AlignmentLayout {
  static constexpr int kClockOffset = 0, kClockDrift = 1, kBoresight = 2, kLeverArm = 5, kGyroBias = 8, kAccelBias = 11,
                       kGyroScale = 14, kAccelScale = 17, kSize = 20;
};

/// Correlation of the norms of the angular rates, which gave the first offset.
struct CorrelationPeak {
  std::vector<double> offset, correlation;  ///< clock offset [s], and coefficient, of all overlaps tried
  double peak_offset = 0, peak = 0;         ///< the best
  double rival = 0;                         ///< the highest coefficient elsewhere
};

/// Offset of the clocks in a stretch of the log, beside what the alignment says: zero if the clock runs evenly.
struct LocalOffset {
  double time = 0;  ///< middle of the stretch, reference time
  double offset = 0, sigma = 0;
};

struct Alignment {
  double clock_offset = 0;  ///< [s] at the first body sample
  double clock_drift = 0;   ///< ratio
  Quaterniond q_rb = Quaterniond::Identity();
  Vector3d p_rb_r = Vector3d::Zero();  ///< r → b, in r
  Vector3d gyro_bias = Vector3d::Zero(), accel_bias = Vector3d::Zero();
  Vector3d gyro_scale = Vector3d::Zero(), accel_scale = Vector3d::Zero();
  /// In the order of AlignmentLayout; boresight as rotation vector β in r, R_rb = Exp(β) R̂_rb. Rows of what is not
  /// determined are infinite on the diagonal and zero elsewhere.
  Eigen::Matrix<double, AlignmentLayout::kSize, AlignmentLayout::kSize> covariance;

  /// What the motion did not determine, in words, such as `lever arm: no rotation moves one IMU against the other`.
  std::vector<std::string> undetermined;
  /// What does not spoil the result, and yet should be known.
  std::vector<std::string> warnings;

  double low_pass = 0;                           ///< [Hz] that both signals went through
  double gyro_residual = 0, accel_residual = 0;  ///< rms of what is left in the band, one axis [rad/s], [m/s²]
  CorrelationPeak correlation;
  std::vector<LocalOffset> local;

  double variance(int index) const { return covariance(index, index); }
  Vector3d sigma(int block) const { return covariance.diagonal().segment<3>(block).cwiseSqrt(); }
  /// `value`, the parameters from `block` on, with zero for those that are not determined.
  Vector3d known(const Vector3d& value, int block) const {
    Vector3d out = value;
    for (int i = 0; i < 3; ++i) {
      if (!std::isfinite(variance(block + i))) out(i) = 0;
    }
    return out;
  }
  /// Time of the reference at time m of the body IMU's clock, whose first sample is at `first`.
  double reference_time(double m, double first) const { return m - clock_offset - clock_drift * (m - first); }
};

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
