#pragma once
/// Corrects the rate with which the gyroscope's scale was propagated, by the gyroscope's noise that an attitude fix
/// reveals. `mend_rate` (model/dynamics.h) says why this is needed.

#include <optional>

#include "model/dynamics.h"
#include "piste/filter/filter_state.h"
#include "piste/model/measurement.h"

namespace piste {

/// Keeps the covariance of the rotation that the gyroscopes' noise made since the last attitude fix.
class RateMending {
 public:
  /// Call it after each step. At rest the step counts for nothing, because the measured rate was not used.
  void add(const Transition& t, bool still) {
    if (!still) noise_ += t.noise.block<3, 3>(6, 6);
  }
  /// Call it before an attitude fix is used. Returns mend_rate() with the noise that the residual of the fix shows.
  /// Returns nothing if the last attitude fix is more than a second old, if the NIS of `lin` is above `bound`, or if
  /// the gyroscope's scale is not estimated.
  std::optional<Transition> before(const Linearization& lin, const FilterState& state, const StateLayout& layout,
                                   double bound);

 private:
  Matrix3d noise_ = Matrix3d::Zero();
  double last_fix_ = -1e300;  // its time
};

}  // namespace piste
