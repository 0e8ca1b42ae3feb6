#pragma once
/// How long the error of a smoothed attitude lasts: what a reader of it must know beside its sigmas.

#include <cstddef>
#include <span>

#include "piste/math/so3.h"

namespace piste {

/// Errors of the smoothed attitude at two epochs, given all data. Rotation vectors in w.
struct AttitudeLag {
  std::size_t early = 0, late = 0;  ///< rows of the solution
  double lag = 0;                   ///< s between them
  Matrix3d covariance;              ///< E[θ_early θ_lateᵀ]
  Matrix3d of_early, of_late;       ///< E[θ θᵀ] of each
};

/// Correlation time of the one Gauss-Markov process, alike on all axes of w, whose correlations exp(−lag / τ) are
/// nearest to those of the attitude's errors: in least squares over all pairs, level counted twice and heading once.
/// So all of a reader's model is held against all of the error, short lags and long ones, and an error that fades as
/// something else than an exponential still gets the time that its sum over a run has. At most the longest lag, which
/// is the answer where the error does not fade within it; 0 of no lag.
double correlation_time(std::span<const AttitudeLag> lags);

}  // namespace piste
