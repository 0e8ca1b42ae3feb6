#pragma once
/// Units and axes of an IMU from the motion of the track: see inspect/log_match.h.

#include <optional>

#include "log_signals.h"
#include "piste/inspect/log_match.h"

namespace piste {

/// With the IMU's clock `offset` ahead of the track's; `rest` in the track's time; gyroscopes that turn `turns` times
/// as fast as the track, 0 where that is not known. nullopt where the motion does not tell, or no reading of the labels
/// fits.
std::optional<MotionMatch> match_motion(const ImuIntegral& imu, bool increments, const Track& track,
                                        const std::vector<Interval>& rest, double offset, double turns);

}  // namespace piste
