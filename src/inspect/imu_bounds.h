#pragma once
/// Common to all checks of an IMU's values: bounds, and the quantization step.

#include <vector>

#include "piste/core/log.h"

namespace piste {

inline constexpr double kFastRates = 35;           ///< rad/s: in no motion is one row in a hundred faster
inline constexpr double kGravityTolerance = 1.35;  ///< allowed factor to the magnitude of gravity, in motion too
/// Least number of quantization steps from zero to the limit of a sensor: the coarsest, of seven bits, has 63. A limit
/// of fewer steps is the rounded rate of a calm body.
inline constexpr double kFewestSteps = 60;

/// The smallest step between consecutive values of an axis; 0 if all are equal.
double smallest_step(const std::vector<Vector3d>& values, int axis);

}  // namespace piste
