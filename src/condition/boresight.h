#pragma once
/// The rotation between two IMUs on one plate, in closed form from their angular rates.

#include <span>

#include "piste/math/so3.h"

namespace piste {

/// R_rb, and how sure it is.
struct BoresightFromRates {
  Quaterniond q_rb = Quaterniond::Identity();
  /// [rad²] of the rotation vector β in r, R_rb = Exp(β) R̂_rb, from the residuals taken as white. Infinite on the
  /// diagonal where the rates do not turn about two axes by more than what noise alone could make of it.
  Matrix3d covariance = Matrix3d::Zero();
  Vector3d gyro_bias = Vector3d::Zero();  ///< of b against r, body axes [rad/s]
  double residual = 0;                    ///< rms of w_b − R_rbᵀ w_r − gyro_bias, of one axis [rad/s]
  double residual_mirrored = 0;  ///< the same if r or b were left-handed where that fits better; else `residual`
};

/// Minimises Σ |w_b − R_rbᵀ w_r − bias|² over rotation and bias: Wahba's problem (math/wahba.h) of the rates about
/// their means. The rates of r and b [rad/s] are of the same instants. Biases do not disturb the result, nor does a
/// filter that is the same on both; scales that differ do. The covariance is σ² (tr(S) I − S)⁻¹ with S = Σ dw_r dw_bᵀ
/// R_rbᵀ, σ² being the variance of the residuals. Noise of r that b does not share leaves S unbiased.
/// @pre equally many rates of both, at least three.
BoresightFromRates boresight_from_rates(std::span<const Vector3d> rate_r, std::span<const Vector3d> rate_b);

}  // namespace piste
