#pragma once
/// The offset of an IMU's clock from the motion, whatever its axes and units are: see inspect/log_match.h.

#include <optional>

#include "log_signals.h"
#include "piste/inspect/log_match.h"

namespace piste {

/// nullopt where the motion does not tell, or tells several.
std::optional<ClockMatch> match_clocks(const ImuIntegral& imu, const Track& track);

/// Turn rate of the gyroscopes over that of the track, with the IMU's clock `offset` ahead; 0 where the turns do not
/// tell.
double turn_ratio(const ImuIntegral& imu, const Track& track, double offset);

}  // namespace piste
