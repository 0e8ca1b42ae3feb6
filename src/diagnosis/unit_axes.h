#pragma once
/// Whether several IMUs that are taken as one turn together, as their axes, boresights and clocks say.

#include <string>
#include <vector>

#include "piste/core/log.h"
#include "piste/core/sensor.h"

namespace piste {

/// A line for each IMU whose rates are not those of the first: turned by some degrees, which is the error of its `axes`
/// or its `boresight`; or different altogether, as those of a wrong clock, unit or file. Of two IMUs nobody can tell
/// which is wrong, and the mean is taken of both: without the line the run would be wrong without a word of why.
/// `units` are the sensors that the mean was made of, the first as well.
std::vector<std::string> unit_axes_lines(const Log& log, const std::vector<ImuSensor>& units);

}  // namespace piste
