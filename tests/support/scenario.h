#pragma once
/// Scenarios of the Monte Carlo suite, made short.

#include <string>

#include "piste/sim/scenario.h"
#include "support/places.h"

namespace piste::test {

/// config/scenarios/montecarlo/NAME.yaml.
inline Scenario suite_scenario(const std::string& name) {
  return read_scenario(source_folder() + "/config/scenarios/montecarlo/" + name + ".yaml");
}

/// Other lengths of the rests and of the run [s], at the same rate of turn.
inline void shorten(Scenario& s, double rest_before, double run, double rest_after) {
  s.motion.net_turn *= run / s.motion.run;
  s.motion.rest_before = rest_before;
  s.motion.run = run;
  s.motion.rest_after = rest_after;
  s.replay.end = run + rest_after;
}

}  // namespace piste::test
