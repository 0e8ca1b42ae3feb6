#pragma once
/// Takes the gyro's noise, as an attitude fix tells it, out of the rate that the gyro's scale was propagated with.

#include <optional>

#include "piste/solve/tape.h"

namespace piste {

/// Keeps how uncertain the angle is that the gyro's noise made since the last attitude fix.
class RateMending {
 public:
  /// A step was propagated over. At rest no measured rate was regressed on.
  void add(const Transition& t, bool still) {
    if (!still) noise_ += t.noise.block<3, 3>(6, 6);
  }
  /// Before an attitude fix is used: mend_rate() by the noise that its residual shows, see dynamics.h. Nothing where
  /// the fix before it is more than a second old, or `lin` lies outside a gate of `bound`, or no scale is estimated.
  std::optional<Transition> before(const Linearization& lin, const FilterState& state, const StateLayout& layout,
                                   double bound);

 private:
  Matrix3d noise_ = Matrix3d::Zero();
  double last_fix_ = -1e300;  // its time
};

}  // namespace piste
