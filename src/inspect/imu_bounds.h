#pragma once
/// What all that examines the values of an IMU's log has in common: bounds, and the steps in which they are written.

#include <vector>

#include "piste/core/log.h"

namespace piste {

inline constexpr double kFastRates = 35;           ///< rad/s: in no motion is one row in a hundred faster
inline constexpr double kGravityTolerance = 1.35;  ///< allowed factor to the magnitude of gravity, in motion too
/// Steps from zero to the limit of a sensor: the coarsest, of seven bits, has 63. What stands nearer to zero is the
/// rounded rate of a calm body.
inline constexpr double kFewestSteps = 60;

/// The smallest step between two values of an axis that follow each other; 0 if all are the same.
double smallest_step(const std::vector<Vector3d>& values, int axis);

}  // namespace piste
