#pragma once
/// The attitude that a run starts with: roll and pitch from rest, or the whole attitude from a few seconds of motion.

#include <optional>
#include <span>

#include "piste/core/log.h"
#include "piste/core/options.h"

namespace piste {

/// The attitude of a body at rest, from its mean specific force in body axes and a given heading [rad]: w's down axis
/// lies along −`mean_force`.
Quaterniond level(const Vector3d& mean_force, double heading);

/// Attitude, velocity and position at the beginning of a window of motion.
struct MotionAlignment {
  double time = 0;  ///< of the beginning
  Quaterniond q_wb;
  Matrix3d covariance;  ///< rotation-vector error in w, rad²
  Vector3d v_wb, p_wb;
};

/// What is known of the gyroscopes' bias before the filter runs: value and 1-sigma [rad/s].
struct GyroBias {
  Vector3d value = Vector3d::Zero();
  double sigma = 0;
};

/// Finds the attitude at fixes.front().time from the IMU and the fixes of a window, in closed form and without a prior.
/// It needs a window in which the velocity changes in more than one direction; at rest use `level`.
///
/// Dead reckoning in the body axes of the beginning gives the antenna's velocity and position up to the unknown
/// attitude R, initial velocity v₀ and position p₀ (Wu and Pan 2013, optimization-based alignment):
///
///     v_a(t) = v₀ + g t + R [u(t) + C(t)(ω × l)]      p_a(t) = p₀ + v₀ t + g t²/2 + R [s(t) + C(t) l]
///
/// Constants (for positions: straight lines) are projected out of both sides, which removes v₀ and p₀. What is left,
/// β_k = R α_k, is Wahba's problem (math/wahba.h). α comes from the IMU and is taken as exact over a window of seconds,
/// so the covariance is (Σ w (|α|² I − α αᵀ))⁻¹ with α turned into w. It is scaled up if the residuals exceed the noise
/// of the fixes, and the rotation that the gyroscopes' unknown bias makes in half the window is added to it. Returns
/// nullopt if the IMU has a gap in the window, if there are fewer than four fixes, or if the motion does not determine
/// every direction.
std::optional<MotionAlignment> align_in_motion(std::span<const ImuSample> imu, std::span<const GnssFix> fixes,
                                               const GnssOptions& receiver, const GyroBias& bias,
                                               const Vector3d& gravity);

}  // namespace piste
