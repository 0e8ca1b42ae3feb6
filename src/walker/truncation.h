#pragma once
/// Truncation of coning and sculling: what a step misses of a motion that turns within few samples, as noise.

#include <array>

#include "model/dynamics.h"
#include "piste/core/log.h"
#include "piste/core/sensor.h"

namespace piste {

/// Estimates the truncation from the samples themselves. A step takes the rate's slope from its two neighbours. Those
/// of five samples give it to a higher order, and for coning the step misses
///
///     e_θ = h²/30 · α × (ω'₂ − ω'₁)        ω'₁ = (ω₊₁ − ω₋₁)/2h,   ω'₂ = (ω₊₂ − ω₋₂)/4h
///     e_v = h²/30 · (α × (f'₂ − f'₁) + υ × (ω'₂ − ω'₁))
///
/// with the increments α and υ of the middle sample: coning by the angle θ at the frequency Ω has θ² (Ωh)⁵ / 60 a step.
/// The factor 1/30 follows from the series of the true increment, θ²/2 (Ωh − sin Ωh), and of the one of a step. Source:
/// Ignagni 1996, for algorithms of more samples. The error is not taken out: beyond the band of these series a
/// correction is wrong, too.
///
/// It lasts as long as the motion does, so that its variance grows with the square of time: with A = Σ e, by
///
///     ΔP = 5/3 (A² − M)        M: the largest A² so far
///
/// a step, where this is positive: errors that alternate cancel in A. The noise of a filter is white. Integrated twice
/// as gravity times tilt, white noise of this growth has 3/5 of the variance that the lasting error has: hence 5/3, and
/// attitudes are as much too wide. A and M decay with the correlation time of the sensor's drift, as what lasts longer
/// is a drift, which has a state. No heap.
class Truncation {
 public:
  /// Takes the sample after the present one, or null. Returns the noise of the present step, which is that of a sample
  /// earlier; zero where five samples do not adjoin.
  StepNoise add(const ImuSample* next, const ImuSensor& sensor);

 private:
  struct Sample {
    double interval = 0;
    Vector3d rate, force;
    bool adjoins = false;  // the one before
  };
  std::array<Sample, 5> last_;  // the newest at the end
  double end_ = 0;              // of the newest
  int count_ = 0;
  struct Lasting {
    Vector3d sum = Vector3d::Zero(), largest = Vector3d::Zero();  // A, M
    double time = 0;                                              // that A is of

    Vector3d add(const Vector3d& e, double h, const TriadErrors& triad);
  } gyro_, accel_;
};

}  // namespace piste
