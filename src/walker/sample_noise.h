#pragma once
/// White noise of one IMU sample: that of the sensor, plus what clipping may hide, plus what a gap or an interpolated
/// row may have missed.

#include <array>

#include "model/dynamics.h"
#include "piste/core/log.h"
#include "piste/core/options.h"

namespace piste {

/// Takes the samples in their order. What n clipped samples in a row hide is one and the same error, whose variance
/// grows with n². The n-th of them therefore adds 2n − 1 times the variance of one.
class SampleNoise {
 public:
  /// Noise of the next sample.
  StepNoise of(const ImuSample& sample, const ImuSensor& sensor);

 private:
  std::array<int, 6> clipped_in_a_row_{};
};

}  // namespace piste
