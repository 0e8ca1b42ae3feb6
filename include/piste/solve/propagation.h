#pragma once
/// Carries estimate and covariance over one IMU step.

#include "piste/solve/tape.h"

namespace piste {

/// Keeps gravity near the body, and the mean force of a body that stands.
class Propagation {
 public:
  Propagation() = default;
  Propagation(const World& world, const Vector3d& p_wb) : gravity_(world.gravity(p_wb)) {}

  /// Linear gravity, within 4e-9 m/s² of the normal one where the last step began.
  const Gravity& gravity() const { return gravity_; }

  /// Advances `state` over `step`, as measured. `still`: the body is at rest. Returns what the error did. No heap.
  Transition advance(FilterState& state, const ImuStep& step, const StepNoise& noise, bool still, const World& world,
                     const StateLayout& layout, const FilterOptions& options);

 private:
  void stand(const Estimate& x, double dt);

  Gravity gravity_;
  Vector3d standing_force_ = Vector3d::Zero();
  double standing_time_ = 0;  // since the rest began
};

}  // namespace piste
