#pragma once
/// Advances estimate and covariance over one IMU step.

#include "piste/solve/recent_motion.h"
#include "piste/solve/standing_force.h"
#include "piste/solve/tape.h"

namespace piste {

/// Keeps three things from step to step: the gravity near the body, the recent motion, and at rest the mean specific
/// force.
class Propagation {
 public:
  /// To be assigned to.
  Propagation() = default;
  /// `p_wb`: where the run begins, in w. `options` tell whether scales of several IMUs act across the axes of their
  /// mean.
  Propagation(const World& world, const Vector3d& p_wb, const FilterOptions& options)
      : units_(UnitScales::across(options)), gravity_(world.gravity(p_wb)) {}

  /// Gravity as a linear function. Where the last step began it is within 4e-9 m/s² of normal gravity.
  const Gravity& gravity() const { return gravity_; }

  /// Rate and force as means over the last samples, in the axes of `q_wb`.
  RecentMotion recent(const Quaterniond& q_wb, const ImuSensor& sensor) const { return motion_.at(q_wb, sensor); }

  /// Of several IMUs; nothing if their scales act along the axes of the body.
  const UnitScales* units() const { return units_.get(); }

  /// Advances `state` over `step`, whose increments are as measured, without_rest(). `still`: the body is at rest.
  /// `known`: rate and force that the scales multiply, where a reference tells them; without it those of the step.
  /// Returns the transition of the error. No heap.
  Transition advance(FilterState& state, const ImuStep& step, const StepNoise& noise, bool still, const World& world,
                     const StateLayout& layout, const FilterOptions& options, const BodyMotion* known = nullptr);

 private:
  std::shared_ptr<const UnitScales> units_;
  Gravity gravity_;
  MotionMean motion_;
  StandingForce standing_;
};

}  // namespace piste
