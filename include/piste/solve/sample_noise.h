#pragma once
/// White noise of one IMU sample: the sensor's own, what clipping hides, and what a gap may have missed.

#include <array>

#include "piste/core/log.h"
#include "piste/core/options.h"
#include "piste/model/dynamics.h"

namespace piste {

/// Looks at the samples in their order: what n clipped samples in a row hide is one error, whose variance grows with
/// n², so that each adds 2n − 1 times the variance of one.
class SampleNoise {
 public:
  StepNoise of(const ImuSample& sample, const ImuSensor& sensor);

 private:
  std::array<int, 6> clipped_in_a_row_{};
};

}  // namespace piste
