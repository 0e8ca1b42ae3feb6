#pragma once
/// The state of a filter at one instant.

#include "piste/core/estimate.h"

namespace piste {

/// Time, estimate and covariance.
struct FilterState {
  double time = 0;
  Estimate x;
  Covariance P;
  /// The error of `x` as the measurements so far have it: the best estimate is x ⊞ mean. Zero in a filter that corrects
  /// `x` itself; in one that is linearised about a reference, `x` is the reference.
  ErrorVector mean = {};
};

}  // namespace piste
