#pragma once
/// How the errors of an IMU change with time: constant, random walk, or first-order Gauss-Markov. Discretised exactly.

#include "piste/core/sensor.h"

namespace piste {

/// One scalar process over a step: x⁺ = transition · x + noise of the given variance.
struct DiscreteProcess {
  double transition = 1, variance = 0;
};

/// The process over a step dt. Gauss-Markov, x' = −x/τ + √(2σ²/τ) w: transition e^{−dt/τ}, variance σ²(1 − e^{−2dt/τ}).
/// Random walk: transition 1, variance density² dt. Example: Gauss-Markov with σ = 2, τ = 100 s and dt = 10 s
/// has the transition 0.905 and the variance 0.725.
DiscreteProcess discretise(const DriftProcess& process, double dt);

/// 1-sigma of a drift at the start of a run: σ for a Gauss-Markov process, 0 for a random walk (its initial value is
/// the turn-on bias).
double initial_sigma(const DriftProcess& process);

/// 1-sigma of the change of a drift between two stretches of time: its mean over the one less its mean over the other.
/// The stretches have the lengths a and b, with a gap g between them.
///
///     Gauss-Markov:  σ √(v(a) + v(b) − 2 c),  v(t) = 2 (τ/t)² (t/τ − 1 + e^(−t/τ)),
///                    c = τ²/(a b) e^(−g/τ) (1 − e^(−a/τ)) (1 − e^(−b/τ))
///     random walk:   density √(a/3 + g + b/3)
double change_sigma(const DriftProcess& process, double a, double gap, double b);

}  // namespace piste
