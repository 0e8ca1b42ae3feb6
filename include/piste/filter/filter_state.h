#pragma once
/// The state of a filter at one instant.

#include "piste/core/estimate.h"

namespace piste {

/// Time, estimate and covariance.
struct FilterState {
  double time = 0;
  Estimate x;
  Covariance P;
  /// Mean of the error of `x`, given the measurements so far: the best estimate is x ⊞ mean. It is zero in a filter
  /// that corrects `x` itself. In a filter that is linearised about a reference, `x` is the reference.
  ErrorVector mean = {};
};

}  // namespace piste
