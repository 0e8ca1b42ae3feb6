#pragma once
/// Whether several IMUs that are taken as one move together, as their axes, boresights, clocks and lever arms say.

#include <string>
#include <vector>

#include "piste/core/log.h"
#include "piste/core/sensor.h"

namespace piste {

/// A line for each IMU that does not move with the first: its rates come early or late, which is the error of its
/// `clock`; they are turned by some degrees, which is that of its `axes` or its `boresight`; or they are different
/// altogether, as those of a wrong unit or file. Or its specific forces are those of another place than its `lever_arm`
/// puts it. Of two IMUs it is not observable which is wrong, and the run uses the mean of both: without the line the
/// run would be wrong without a reason given. `imus` are the sensors that the mean was made of, the first as well.
std::vector<std::string> imu_motion_lines(const Log& log, const std::vector<ImuSensor>& imus);

}  // namespace piste
