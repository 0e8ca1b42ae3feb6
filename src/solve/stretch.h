#pragma once
// How far the gyro turned in a stretch of a log.

#include "piste/core/log.h"
#include "piste/core/time_search.h"

namespace piste {

/// Rotation of the body from `begin` to `end` by the gyro alone, less a constant rate; b(begin) ← b(end).
Quaterniond turned(const Log& log, double begin, double end, const Vector3d& bias);

}  // namespace piste
