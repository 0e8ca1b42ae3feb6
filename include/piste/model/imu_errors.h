#pragma once
/// How the errors of an IMU evolve: random constant, random walk, first-order Gauss-Markov, discretised exactly.

#include "piste/core/sensor.h"

namespace piste {

/// One scalar process over a step: x⁺ = transition · x + noise of the given variance.
struct DiscreteProcess {
  double transition = 1, variance = 0;
};

/// Gauss-Markov: x' = −x/τ + √(2σ²/τ) w gives e^{−dt/τ} and σ²(1 − e^{−2dt/τ}); random walk: 1 and density² dt.
DiscreteProcess discretise(const DriftProcess& process, double dt);

/// 1-sigma of a drift at the start of a run: σ of a Gauss-Markov process, 0 of a random walk (its level is the
/// turn-on bias).
double initial_sigma(const DriftProcess& process);

/// 1-sigma of the change of a drift over a lapse of time: σ √(2 (1 − e^{−lapse/τ})) of a Gauss-Markov process,
/// density √lapse of a random walk.
double change_sigma(const DriftProcess& process, double lapse);

}  // namespace piste
