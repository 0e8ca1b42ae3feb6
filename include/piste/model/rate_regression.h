#pragma once
/// The regression of a rate on the rates of the neighbouring samples: an errors-in-variables correction.
///
/// The Jacobian of a velocity by lever arm and scale is the body's rate, and the measured rate has noise. The noise of
/// the neighbouring samples (model/strapdown.h) does not correlate with the residual, but makes the Jacobian too large.
/// In calm motion that noise would pass for motion that determines the lever arm. The conditional mean of the rate for
/// given neighbours ω̃ avoids both (regression calibration; Carroll, Ruppert, Stefanski and Crainiceanu 2006, chapter
/// 4):
///
///     E[ω | ω̃] = G ω̃,   G = E[ω ω̃ᵀ] E[ω̃ ω̃ᵀ]⁻¹,
///
/// with means over the last seconds. The noise of a sample is not in its neighbours, so that its density need not be
/// known. Where a body turns about one axis, G keeps this axis, and removes nearly all noise about the others.

#include "piste/core/estimate.h"
#include "piste/core/log.h"

namespace piste {

/// The regression, with exponentially forgotten moments.
class RateRegression {
 public:
  /// s. Of noise alone, some 1/√n of n samples remains. After strong motion its rates count for several times as long.
  static constexpr double kMemory = 5;

  /// Adds a sample and the mean rate of its neighbours as measured [rad/s] (neighbour_rate()), both corrected by the
  /// errors in `x`. A sample without an adjoining neighbour is left out.
  void add(const ImuSample& sample, const Vector3d& beside, const Estimate& x);
  /// G; the identity before the first sample.
  Matrix3d matrix() const;

 private:
  Matrix3d cross_ = Matrix3d::Zero(), square_ = Matrix3d::Zero();  // E[ω ω̃ᵀ], E[ω̃ ω̃ᵀ]
  double samples_ = 0;
};

}  // namespace piste
