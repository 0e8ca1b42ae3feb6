#pragma once
// The rotation of the body by the gyroscopes over a stretch of a log.

#include "core/time_search.h"
#include "piste/core/log.h"

namespace piste {

/// The rotation of the body from `begin` to `end` by the gyroscopes without `bias` [rad/s]. It turns components along
/// the body axes at `end` into those along the axes at `begin`.
Quaterniond turned(const Log& log, double begin, double end, const Vector3d& bias);

}  // namespace piste
