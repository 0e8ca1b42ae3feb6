#pragma once
/// Finds the rotation between two IMUs on one plate from their angular rates, in closed form.

#include <span>

#include "piste/math/so3.h"

namespace piste {

/// The boresight R_rb and its covariance.
struct BoresightFromRates {
  Quaterniond q_rb = Quaterniond::Identity();
  /// Of the rotation vector β in r [rad²], R_rb = Exp(β) R̂_rb, as if the residuals were white. Infinite on the
  /// diagonal if the rates do not turn about two axes by more than noise alone would.
  Matrix3d covariance = Matrix3d::Zero();
  Vector3d gyro_bias = Vector3d::Zero();  ///< of b against r, body axes [rad/s]
  double residual = 0;                    ///< rms of w_b − R_rbᵀ w_r − gyro_bias, of one axis [rad/s]
  double residual_mirrored = 0;           ///< the same with one IMU left-handed, if that fits better; else `residual`
};

/// Minimises Σ |w_b − R_rbᵀ w_r − bias|² over rotation and bias. This is Wahba's problem (math/wahba.h) for the rates
/// less their means. Biases do not disturb the result, and neither does a filter that is the same on both; different
/// scales do. The covariance is σ² (tr(S) I − S)⁻¹ with S = Σ dw_r dw_bᵀ R_rbᵀ and σ² the variance of the residuals.
/// Noise of r that b does not share leaves S unbiased.
/// @pre The rates [rad/s] of r and b are at the same times, as many of both, and at least three.
BoresightFromRates boresight_from_rates(std::span<const Vector3d> rate_r, std::span<const Vector3d> rate_b);

}  // namespace piste
