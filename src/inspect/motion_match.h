#pragma once
/// Estimates units and axes of an IMU from the motion of the track: see inspect/log_match.h.

#include <optional>

#include "log_signals.h"
#include "piste/inspect/log_match.h"

namespace piste {

/// Units and axes. `offset`: by how much the IMU's clock is ahead of the track's. `rest`: stationary times, in the
/// track's time. `turns`: turn rate of the gyroscopes divided by that of the track, 0 if unknown. Returns nullopt if
/// the motion does not determine units and axes, or if none fit.
std::optional<MotionMatch> match_motion(const ImuIntegral& imu, bool increments, const Track& track,
                                        const std::vector<Interval>& rest, double offset, double turns);

}  // namespace piste
