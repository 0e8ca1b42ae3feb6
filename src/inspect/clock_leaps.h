#pragma once
/// Steps forward of an IMU's clock that was set while it ran. By the IMU's log alone they look as missing rows do.

#include <vector>

#include "piste/core/log.h"
#include "piste/inspect/gnss_health.h"

namespace piste {

/// The gaps of an IMU's log that are steps of its clock. The motion before and behind such a gap gives two offsets
/// against the receiver's clock. They differ by the excess of the gap over one interval. `gaps`: each from the row
/// before it to the row after it, as Sampling has them. A gap remains one if the motion does not determine both
/// offsets.
std::vector<ClockStep> clock_leaps(const ImuRecording& imu, const std::vector<Interval>& gaps,
                                   const GnssRecording& gnss, const GnssHealth& health);

}  // namespace piste
