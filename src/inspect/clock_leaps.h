#pragma once
/// Steps forward of an IMU's clock that was set while it ran. By the IMU's log alone they look as missing rows do.

#include <vector>

#include "piste/core/log.h"
#include "piste/inspect/gnss_health.h"

namespace piste {

/// The gaps of an IMU's log that are steps of its clock: the offset against the receiver's clock, by the motion before
/// and behind the gap, changes by what the stamps have more than one row. `gaps`: each from the row before it to the
/// row after it, as Sampling has them. Where the motion does not tell the offset on both sides, a gap stays one.
std::vector<ClockStep> clock_leaps(const ImuRecording& imu, const std::vector<Interval>& gaps,
                                   const GnssRecording& gnss, const GnssHealth& health);

}  // namespace piste
