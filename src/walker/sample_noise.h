#pragma once
/// White noise of one IMU sample: that of the sensor, plus what clipping may hide, plus what a gap or an interpolated
/// row may miss.

#include <array>

#include "model/dynamics.h"
#include "piste/core/log.h"
#include "piste/core/options.h"

namespace piste {

/// Takes the samples in order. The hidden errors of n clipped samples in a row are fully correlated, so that the
/// variance of their sum grows with n². The n-th of them therefore adds 2n − 1 times the variance of one.
class SampleNoise {
 public:
  /// Noise of the next sample.
  StepNoise of(const ImuSample& sample, const ImuSensor& sensor);

 private:
  std::array<int, 6> clipped_in_a_row_{};
};

}  // namespace piste
