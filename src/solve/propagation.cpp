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
    standing_.stand(state.x, gravity_.value, step.dt);
  } else {
    standing_.move();
  }
  Transition t =
      linearize(before, state.x, corrected, world.earth_rate(), gravity_, noise, still ? &standing_.value() : nullptr);
  if (known != nullptr && !still) {
    t.rate = t.step.rate = known->rate;
    t.force = t.step.force = known->force;
  }
  t.units = units_.get();
  add_processes(t, layout, options, step.dt);
  decay(state.x, layout, t);
  propagate(state.P, layout, t);
  if (known != nullptr) propagate(state.mean, layout, t);
  state.time += step.dt;
  return t;
}

}  // namespace piste
