#pragma once
/// The unit of gyroscopes by the direction of gravity.

#include <optional>

#include "piste/core/log.h"

namespace piste {

/// The factor of the rates with which the direction of the specific force turns in the body as they say, u' = -w x u.
/// It is 1, or that from degrees to radians, or back. Nothing if it is not observable: without turns about level axes,
/// or on a multirotor, whose force stays along its own axis. Of increments: nothing.
std::optional<double> rate_factor_by_tilt(const ImuRecording& imu);

}  // namespace piste
