#pragma once
/// White noise of one IMU sample: that of the sensor, plus what clipping may hide, plus what a gap or an interpolated
/// row may miss; and the mean of what clipping hides.
///
/// A sample at +r says that the rate, or the force, is r or more. Of a normal signal with mean m and standard deviation
/// σ, the part beyond r is the truncated normal (Johnson, Kotz and Balakrishnan 1994, section 13.10)
///
///     E(x − r | x > r) = σ (λ − α),   Var(x | x > r) = σ² (1 + α λ − λ²),   α = (r − m) / σ,   λ = φ(α) / Q(α)
///
/// with φ the density and Q the upper tail of the standard normal. The samples determine α: Q(α) is the share of those
/// that are clipped on this side, (c + ½) / (n + 1) of n samples of a moving body (Jeffreys). The mean m is theirs, and
/// σ = (r − m) / α, at most r. Likewise at −r.
///
/// Example: a gyroscope of ±300 deg/s, of which 1 % of the samples are clipped at +300 and whose mean is 0, has α =
/// 2.33 and σ = 129 deg/s. A clipped sample hides 44 ± 40 deg/s.

#include <array>

#include "model/dynamics.h"
#include "piste/core/log.h"
#include "piste/core/options.h"

namespace piste {

/// Mean and variance of the part of a normal signal beyond a limit: its excess.
struct HiddenExcess {
  double mean = 0, variance = 0;
};

/// The excess over `range` of a signal with this mean, of whose samples the part `share` is beyond it. 0 < share < 1.
HiddenExcess hidden_excess(double range, double mean, double share);

/// Noise of a sample, and the mean of what clipping hides in it: an angular rate and a specific force.
struct ClippedNoise {
  StepNoise noise;
  Vector3d hidden_rate = Vector3d::Zero(), hidden_force = Vector3d::Zero();
};

/// Takes the samples in order. The hidden errors of n clipped samples in a row are fully correlated, so that the
/// variance of their sum grows with n². The n-th of them therefore adds 2n − 1 times the variance of one.
class SampleNoise {
 public:
  /// Noise of the next sample.
  ClippedNoise of(const ImuSample& sample, const ImuSensor& sensor);

 private:
  struct Axis {
    int in_a_row = 0;
    double count = 0, sum = 0;                // samples under way, and of their values
    std::array<double, 2> clipped{0.0, 0.0};  // of them, at the negative and at the positive end
    HiddenExcess add(double value, bool clips, bool moves, double range);
  };
  std::array<Axis, 6> axes_{};
};

}  // namespace piste
