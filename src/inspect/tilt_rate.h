#pragma once
/// The unit of gyroscopes by the direction of gravity.

#include <optional>

#include "piste/core/log.h"

namespace piste {

/// The factor by which the rates must be multiplied so that the direction of the specific force turns in the body as
/// they say, u' = -w x u: 1, or that from degrees to radians, or back. Nothing where they do not tell: without turns
/// about level axes, or as a multirotor, whose force stays along its own axis. Of increments: nothing.
std::optional<double> rate_factor_by_tilt(const ImuRecording& imu);

}  // namespace piste
