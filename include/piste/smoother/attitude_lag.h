#pragma once
/// Correlation time of the error of a smoothed attitude. Another replay that uses the attitude as a measurement needs
/// it, in addition to the sigmas.

#include <cstddef>
#include <span>

#include "piste/math/so3.h"

namespace piste {

/// Covariance of the smoothed attitude's errors at two epochs, given all data. Errors are rotation vectors in the local
/// level.
struct AttitudeLag {
  std::size_t early = 0, late = 0;  ///< rows of the solution
  double lag = 0;                   ///< s between them
  Matrix3d covariance;              ///< E[θ_early θ_lateᵀ]
  Matrix3d of_early, of_late;       ///< E[θ θᵀ] of each
};

/// Number of late epochs of a run, and of earlier epochs with which each is compared, evenly spread. These are some
/// 2000 pairs. They determine the correlation time to a few per cent, at little cost compared with the smoother.
inline constexpr std::size_t kLateEpochs = 16, kEarlyEpochs = 256;

/// The correlation time τ [s] of a Gauss-Markov process, the same on all axes of w, that best fits the errors of the
/// attitude. Its correlations exp(−lag / τ) are fitted to those of the errors by least squares over all pairs. The
/// level axes count twice and the heading once.
///
/// All lags, short and long, enter the fit. An error that does not decorrelate exponentially thus still gets a τ that
/// suits its sum over a run. The result is at most the longest lag, which it is if the error does not decorrelate
/// within it. It is 0 if there are no pairs.
double correlation_time(std::span<const AttitudeLag> lags);

}  // namespace piste
