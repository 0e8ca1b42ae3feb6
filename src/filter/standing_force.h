#pragma once
/// The specific force on a body at rest, as a mean over its rest.

#include "piste/core/estimate.h"

namespace piste {

/// The mean over a rest so far of the specific force that gravity causes on the body's axes. The attitude of a single
/// epoch follows the accelerometers' noise through the zero-velocity updates, and over minutes the scale would follow
/// that noise.
class StandingForce {
 public:
  /// Takes in `dt` seconds at rest with the attitude of `x`, or of motion. `gravity`: in the world frame. Returns the
  /// mean, or null while the body moves.
  const Vector3d* add(bool at_rest, const Estimate& x, const Vector3d& gravity, double dt) {
    time_ = at_rest ? time_ + dt : 0;
    if (!at_rest) return nullptr;
    value_ -= dt / time_ * (x.q_wb.conjugate() * gravity + value_);
    return &value_;
  }

 private:
  Vector3d value_ = Vector3d::Zero();
  double time_ = 0;  // since the rest began
};

}  // namespace piste
