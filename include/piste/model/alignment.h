#pragma once
/// Attitude of a start: level at rest, or whole from a few seconds of motion.

#include <optional>
#include <span>

#include "piste/core/log.h"
#include "piste/core/options.h"

namespace piste {

/// Attitude with the given heading [rad] whose down axis lies along −`mean_force` (body axes, of a body at rest).
Quaterniond level(const Vector3d& mean_force, double heading);

/// What some seconds of motion say of the window's start. Body axes and w.
struct MotionAlignment {
  double time = 0;
  Quaterniond q_wb;
  Matrix3d covariance;  ///< rotation-vector error in w, rad²
  Vector3d v_wb, p_wb;
};

/// Knowledge of the gyro before the filter has any: a bias [rad/s] and its 1-sigma.
struct GyroBias {
  Vector3d value = Vector3d::Zero();
  double sigma = 0;
};

/// Attitude at fixes.front().time from the IMU and the fixes of a window, in closed form and without any prior.
///
/// Dead reckoning in the body axes of the start gives velocity and position but for the attitude R, initial velocity v₀
/// and position p₀ (Wu and Pan 2013, optimization-based alignment):
///     v_a(t) = v₀ + g t + R [u(t) + C(t)(ω × l)]      p_a(t) = p₀ + v₀ t + g t²/2 + R [s(t) + C(t) l]
/// Projecting constants (and lines, for positions) out of both sides leaves β_k = R α_k: Wahba's problem, solved by SVD
/// (Markley). Its covariance is (Σ w (|α|² I − α αᵀ))⁻¹, scaled by the residuals where they exceed the noise, plus what
/// the gyro's unknown bias turns in half the window. nullopt where a direction stays undetermined.
std::optional<MotionAlignment> align_in_motion(std::span<const ImuSample> imu, std::span<const GnssFix> fixes,
                                               const GnssOptions& receiver, const GyroBias& bias,
                                               const Vector3d& gravity);

}  // namespace piste
