#pragma once
/// Compares an attitude log with an IMU on the same body, by their angular rates.

#include <optional>
#include <string>
#include <vector>

#include "piste/core/log.h"
#include "piste/inspect/suspicion.h"

namespace piste {

/// What the rates tell. The reference axes are those of the attitude log, r; s are the sensor axes of the IMU.
struct AttitudeFit {
  double offset = 0, sigma_offset = 0;   ///< time of the IMU's clock minus that of the attitude's, of one moment [s]
  Matrix3d axes = Matrix3d::Identity();  ///< the signed permutation that is nearest to the rotation from s to r
  Quaterniond left = Quaterniond::Identity();  ///< the rotation that is left over, from the axes so named to r
  Vector3d sigma_left = Vector3d::Zero();      ///< 1-sigma of its roll, pitch and heading [rad]
  Vector3d gyro_bias = Vector3d::Zero();       ///< of the IMU against the attitude, sensor axes [rad/s]
  double residual = 0;                         ///< rms of one axis [rad/s]
  double rate = 0;                             ///< rms of the rates of the IMU about their mean, of one axis [rad/s]
};

/// The comparison.
struct AttitudeMatch {
  Interval imu, attitude;  ///< spans
  double overlap = 0;      ///< seconds in common, by the clocks as they are
  double interval = 0;     ///< of the IMU's rows [s]
  double correlation = 0;  ///< of the magnitudes of the rates at the likeliest offset
  std::optional<AttitudeFit> fit;
  std::string why_not;  ///< without a fit: why
  /// Without a fit: whether the rates differ by more than units and noise do, as if one log were frozen.
  bool far_from_unit = false;

  /// Whether the attitude's delay is surely not zero, if the IMU's clock is ahead of GPS time by `imu_offset` [s]:
  /// beyond three sigmas, 5 ms, and what is not known because a row of the IMU may be a mean over its interval or a
  /// sample at its end.
  bool is_late(double imu_offset = 0) const;
};

/// Compares an attitude log with an IMU. The differences of consecutive attitudes are mean rates of the reference axes.
///
/// The offset of the clocks is first that at which the magnitudes of both rates correlate best, over the whole length
/// of both logs, so that the clocks need not overlap. Then offset δ, rotation, bias and scale of the gyroscopes are
/// fitted to the rotation vectors over each interval of the attitudes,
///
///     φ_r(t₀, t₁) = R_rs ((1 − scale) φ_s(t₀ + δ, t₁ + δ) − (t₁ − t₀) bias),
///
/// without those that are off by more than five sigmas. The sigmas take into account that residuals are correlated.
/// A scale that no gyroscope has is no fit: it hides an axis that is reversed, or another run.
/// @pre rows are in the order of time, as read_imu and read_attitude give them
AttitudeMatch match(const ImuRecording& imu, const AttitudeRecording& attitude);

/// The delay of the attitudes in GPS time [s], if the IMU's clock is ahead of it by `imu_offset`: an attitude stamped t
/// is that of t − delay.
double attitude_delay(const AttitudeFit& fit, double imu_offset);

/// The line of a configuration that makes up for it, such as `delay: 0.0155 s`.
std::string attitude_delay_text(const AttitudeFit& fit, double imu_offset);

/// What looks wrong between the two. `axes` are those of the IMU, R_bs, as far as they are known otherwise.
std::vector<Suspicion> suspicions(const AttitudeMatch& match, const Matrix3d& axes, const std::string& imu_file,
                                  const std::string& attitude_file);

}  // namespace piste
