#pragma once
/// What stands in the IMU's log where nothing was measured.

#include <vector>

#include "piste/core/log.h"

namespace piste {

/// Fills the samples marked as gaps, whose times and intervals are set: with the straight line between the mean rates
/// of the 0.2 s on either side, as far as they were measured, and with the noise that this line has. That is measured:
/// the line is drawn over every stretch of the gap's length within 10 s of it (or five lengths, where that is more),
/// and twice the rms of what it misses there, as a random walk, on the worst axis, is the noise: motion in the gap need
/// not be like that about it. Where fewer than four lengths were measured nearby it is 1 rad/s/sqrt(Hz) and
/// 3 m/s²/sqrt(Hz).
/// @pre some sample is no gap
void fill_gaps(std::vector<ImuSample>& imu);

}  // namespace piste
