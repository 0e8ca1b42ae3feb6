#include "piste/solve/propagation.h"

namespace piste {

Transition Propagation::advance(FilterState& state, const ImuStep& step, const StepNoise& noise, bool still,
                                const World& world, const StateLayout& layout, const FilterOptions& options,
                                const BodyMotion* known) {
  world.follow(gravity_, state.x.p_wb);
  const ImuStep corrected = correct(step, state.x);
  const Estimate before = state.x;
  mechanize(state.x, corrected, world.earth_rate(), gravity_);
  motion_.add(step, state.x.q_wb);
  if (still) {
    stand(state.x, step.dt);
  } else {
    standing_time_ = 0;
  }
  Transition t =
      linearize(before, state.x, corrected, world.earth_rate(), gravity_, noise, still ? &standing_force_ : nullptr);
  if (known != nullptr && !still) {
    t.rate = t.step.rate = known->rate;
    t.force = t.step.force = known->force;
  }
  add_processes(t, layout, options, step.dt);
  decay(state.x, layout, t);
  propagate(state.P, layout, t);
  if (known != nullptr) propagate(state.mean, layout, t);
  state.time += step.dt;
  return t;
}

// Updates the mean over the rest so far of the specific force that gravity causes on the body's axes. The attitude of a
// single epoch follows the accelerometers' noise through the zero-velocity updates, and over minutes the scale would
// follow that noise.
void Propagation::stand(const Estimate& x, double dt) {
  standing_time_ += dt;
  standing_force_ -= dt / standing_time_ * (x.q_wb.conjugate() * gravity_.value + standing_force_);
}

}  // namespace piste
