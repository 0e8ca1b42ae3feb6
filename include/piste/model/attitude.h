#pragma once
/// Attitude of a reference IMU, seen through the boresight.
///
///     R_wr = Exp(n) Exp(a) R_wb R_rbᵀ        residual z = Log(R_wr,measured (Exp(â) R̂_wb R̂_rbᵀ)ᵀ)
///
/// a coloured error of the reference, n its white error, both rotation vectors in w. The boresight stands on the right
/// of R_wb, on the body's side (the article prints the other). Moving the prediction by Exp(η) from the left changes z
/// by −J_r⁻¹(z) η, whence the Jacobians.

#include "piste/core/options.h"
#include "piste/model/measurement.h"

namespace piste {

/// `coloured`: the attitude_drift block carries the error, and the white part is 10 % of the fix's sigma.
Linearization linearize_attitude(const AttitudeFix& fix, bool coloured, const Estimate& x);

/// Heading of the body: its attitude and the 1-sigma [rad] of the rotation about the vertical. The tilt is not used.
struct HeadingFix {
  double time = 0;
  Quaterniond q_wb;
  double sigma = 0;
};

/// One row: the rotation about w's down axis from the estimated attitude to the given one.
Linearization linearize_heading(const HeadingFix& fix, const Estimate& x);

}  // namespace piste
