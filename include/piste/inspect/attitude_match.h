#pragma once
/// Compares an attitude log with an IMU on the same body, by their angular rates.

#include <optional>
#include <string>
#include <vector>

#include "piste/core/log.h"
#include "piste/inspect/suspicion.h"

namespace piste {

/// The fit of the rates. The reference axes r are the axes of the attitude log; s are the sensor axes of the IMU.
struct AttitudeFit {
  double offset = 0, sigma_offset = 0;         ///< simultaneous IMU clock minus attitude clock [s]
  Matrix3d axes = Matrix3d::Identity();        ///< signed permutation nearest to the rotation from s to r
  Quaterniond left = Quaterniond::Identity();  ///< residual rotation, from the axes so named to r
  Vector3d sigma_left = Vector3d::Zero();      ///< 1-sigma of roll, pitch and heading of `left` [rad]
  Vector3d gyro_bias = Vector3d::Zero();       ///< of the IMU against the attitude, sensor axes [rad/s]
  double residual = 0;                         ///< rms of the residuals of one axis [rad/s]
  double rate = 0;                             ///< rms of the IMU's rates about their mean, of one axis [rad/s]
};

/// The comparison.
struct AttitudeMatch {
  Interval imu, attitude;  ///< spans
  double overlap = 0;      ///< seconds in common, by the clocks as logged
  double interval = 0;     ///< of the IMU's rows [s]
  double correlation = 0;  ///< of the rate magnitudes at the best offset
  std::optional<AttitudeFit> fit;
  std::string why_not;  ///< why there is no fit; empty with one
  /// Without a fit: whether the rates differ by more than units and noise explain, as if one log were frozen.
  bool contradicts = false;

  /// Whether the attitude's delay is significant, if the IMU's clock is ahead of GPS time by `imu_offset` [s]. It must
  /// exceed 3 sigmas, 5 ms, and the ambiguity of a row: a row of the IMU may be a mean over its interval or a sample at
  /// its end.
  bool is_late(double imu_offset = 0) const;
};

/// Compares an attitude log with an IMU. The differences of consecutive attitudes are mean rates of the reference axes.
///
/// The clock offset is first estimated as the one with the largest correlation of the rate magnitudes. This search
/// covers the whole length of both logs, so the clocks need not overlap. Then offset δ, rotation, bias and scale of the
/// gyroscopes are fitted to the rotation vectors over each interval of the attitudes,
///
///     φ_r(t₀, t₁) = R_rs ((1 − scale) φ_s(t₀ + δ, t₁ + δ) − (t₁ − t₀) bias),
///
/// without residuals beyond five sigmas. The sigmas account for the correlation of the residuals. A scale that no
/// gyroscope has is no fit: it hides a reversed axis, or another run.
/// @pre rows are in the order of time, as read_imu and read_attitude give them
AttitudeMatch match(const ImuRecording& imu, const AttitudeRecording& attitude);

/// The delay of the attitudes in GPS time [s], if the IMU's clock is ahead of GPS time by `imu_offset`. An attitude
/// stamped t is valid at t − delay: with 0.0155 s, the attitude stamped 100 s at 99.9845 s.
double attitude_delay(const AttitudeFit& fit, double imu_offset);

/// The configuration line that corrects the delay, such as `delay: 0.0155 s`.
std::string attitude_delay_text(const AttitudeFit& fit, double imu_offset);

/// Lists the faults of the two logs relative to each other. `axes`: R_bs of the IMU, if it is known from another
/// source.
std::vector<Suspicion> suspicions(const AttitudeMatch& match, const Matrix3d& axes, const std::string& imu_file,
                                  const std::string& attitude_file);

}  // namespace piste
