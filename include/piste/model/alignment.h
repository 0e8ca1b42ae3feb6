#pragma once
/// Attitude of a start: level at rest, or whole from a few seconds of motion.

#include <optional>
#include <span>

#include "piste/core/log.h"
#include "piste/core/options.h"

namespace piste {

/// The attitude with the given heading [rad] whose down axis lies along −`mean_force`, the specific force of a body at
/// rest in body axes.
Quaterniond level(const Vector3d& mean_force, double heading);

/// Attitude, velocity and position at the start of a window, as some seconds of motion tell them.
struct MotionAlignment {
  double time = 0;
  Quaterniond q_wb;
  Matrix3d covariance;  ///< rotation-vector error in w, rad²
  Vector3d v_wb, p_wb;
};

/// What is known of the gyro's bias [rad/s] before the filter runs, and its 1-sigma.
struct GyroBias {
  Vector3d value = Vector3d::Zero();
  double sigma = 0;
};

/// Attitude at fixes.front().time from the IMU and the fixes of a window, in closed form and without any prior.
///
/// Dead reckoning in the body axes of the start gives velocity and position but for the attitude R, initial velocity v₀
/// and position p₀ (Wu and Pan 2013, optimization-based alignment):
///     v_a(t) = v₀ + g t + R [u(t) + C(t)(ω × l)]      p_a(t) = p₀ + v₀ t + g t²/2 + R [s(t) + C(t) l]
/// Projecting constants (and lines, for positions) out of both sides leaves β_k = R α_k, which is Wahba's problem
/// (math/wahba.h). α comes from the IMU and is taken as exact over a window of seconds, so that the covariance is
/// (Σ w (|α|² I − α αᵀ))⁻¹ with α turned into w. It is scaled by the residuals where they exceed the noise of the
/// fixes, and what the gyro's unknown bias turns in half the window is added to it. nullopt where the IMU has a gap in
/// the window, where there are fewer than four fixes, or where a direction stays undetermined.
std::optional<MotionAlignment> align_in_motion(std::span<const ImuSample> imu, std::span<const GnssFix> fixes,
                                               const GnssOptions& receiver, const GyroBias& bias,
                                               const Vector3d& gravity);

}  // namespace piste
