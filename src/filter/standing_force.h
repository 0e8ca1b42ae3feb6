#pragma once
/// The specific force on a stationary body, as a mean over the standstill.

#include "piste/core/estimate.h"

namespace piste {

/// The mean of the specific force that gravity causes on the body's axes, over the current standstill. The attitude of
/// a single epoch follows the accelerometers' noise through the zero-velocity updates. Over minutes the scale would
/// follow that noise.
class StandingForce {
 public:
  /// Adds `dt` seconds at standstill with the attitude of `x`, or of motion. `gravity`: in the world frame. Returns the
  /// mean, or null in motion.
  const Vector3d* add(bool at_rest, const Estimate& x, const Vector3d& gravity, double dt) {
    time_ = at_rest ? time_ + dt : 0;
    if (!at_rest) return nullptr;
    value_ -= dt / time_ * (x.q_wb.conjugate() * gravity + value_);
    return &value_;
  }

 private:
  Vector3d value_ = Vector3d::Zero();
  double time_ = 0;  // s since the standstill began
};

}  // namespace piste
