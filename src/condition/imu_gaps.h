#pragma once
/// Fills the gaps of an IMU's log.

#include <vector>

#include "piste/core/behaviour.h"
#include "piste/core/log.h"

namespace piste {

/// Fills the samples that are marked as gaps, whose times and intervals are set already. The rates lie on the straight
/// line between the mean rates of the measured samples of the 0.2 s on either side.
///
/// The noise of this line is measured in the log. The same line is drawn over every stretch of the gap's length within
/// 10 s of the gap (or five times its length, if that is more), and compared with the measured samples. The noise is
/// twice the rms of the difference, as a random walk, on the worst axis. The factor of two allows for a motion in the
/// gap that differs from that around it. If less than four times the gap's length was measured nearby, the noise is 1
/// rad/s/sqrt(Hz) and 3 m/s²/sqrt(Hz). These numbers are the defaults of the options.
/// @pre some sample is not a gap
void fill_gaps(std::vector<ImuSample>& imu, const GapOptions& options = {});

}  // namespace piste
