#pragma once
/// What the rates of neighbouring samples tell of the rate between them.
///
/// The Jacobian of a velocity by lever arm and scale is the body's rate, and the measured rate has noise. That of the
/// samples beside (model/strapdown.h) does not correlate with the residual, but makes the Jacobian larger than it is:
/// in calm the noise passes for motion that tells the lever arm. The mean rate for given neighbours ω̃ does not (errors
/// in variables by regression calibration; Carroll, Ruppert, Stefanski and Crainiceanu 2006, chapter 4):
///
///     E[ω | ω̃] = G ω̃,   G = E[ω ω̃ᵀ] E[ω̃ ω̃ᵀ]⁻¹,
///
/// with means over the last seconds. The noise of a sample is not in its neighbours, so that no density of it need be
/// known: where a body turns about one axis, G keeps this axis, and leaves next to nothing of the noise about the
/// others.

#include "piste/core/estimate.h"
#include "piste/core/log.h"

namespace piste {

/// The regression, of moments that are forgotten exponentially.
class RateRegression {
 public:
  /// s. Of noise alone, some 1/√n of n samples is left; after lively motion its rates count for several times as long.
  static constexpr double kMemory = 5;

  /// Adds a sample and the mean rate of those beside it as measured [rad/s] (rate_beside()), from which it takes the
  /// errors that `x` has. A sample that none touches is left out.
  void add(const ImuSample& sample, const Vector3d& beside, const Estimate& x);
  /// G; the identity before the first sample.
  Matrix3d matrix() const;

 private:
  Matrix3d cross_ = Matrix3d::Zero(), square_ = Matrix3d::Zero();  // E[ω ω̃ᵀ], E[ω̃ ω̃ᵀ]
  double samples_ = 0;
};

}  // namespace piste
