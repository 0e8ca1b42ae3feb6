#pragma once
/// Correlation time of the error of a smoothed attitude. Another replay that reads the attitude as a measurement must
/// know it, beside the sigmas.

#include <cstddef>
#include <span>

#include "piste/math/so3.h"

namespace piste {

/// Covariance of the smoothed attitude's errors at two epochs, given all data. Errors are rotation vectors along the
/// local level.
struct AttitudeLag {
  std::size_t early = 0, late = 0;  ///< rows of the solution
  double lag = 0;                   ///< s between them
  Matrix3d covariance;              ///< E[θ_early θ_lateᵀ]
  Matrix3d of_early, of_late;       ///< E[θ θᵀ] of each
};

/// Of a run so many late epochs are each compared with so many earlier ones, evenly spread: some 2000 pairs, which tell
/// the correlation time to a few per cent and cost little beside the smoother.
inline constexpr std::size_t kLateEpochs = 16, kEarlyEpochs = 256;

/// The correlation time τ of a Gauss-Markov process that is the same on all axes of w and that fits the errors of the
/// attitude best. Its correlations exp(−lag / τ) are fitted to those of the errors by least squares over all pairs, in
/// which the level axes count twice and the heading once.
///
/// All lags, short and long, enter the fit, so that an error that does not fade exponentially still gets a τ that suits
/// its sum over a run. The result is at most the longest lag, which it is if the error does not fade within it. It is 0
/// if there are no pairs.
double correlation_time(std::span<const AttitudeLag> lags);

}  // namespace piste
