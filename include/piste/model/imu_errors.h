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

/// 1-sigma of the mean of a drift over one stretch of time less its mean over another, which does not overlap it.
/// With lengths a and b, and a gap g between them: of a Gauss-Markov process σ √(v(a) + v(b) − 2 c),
/// v(t) = 2 (τ/t)² (t/τ − 1 + e^(−t/τ)), c = τ²/(a b) e^(−g/τ) (1 − e^(−a/τ)) (1 − e^(−b/τ)); of a random walk
/// density √(a/3 + g + b/3).
double change_sigma(const DriftProcess& process, double a, double gap, double b);

}  // namespace piste
