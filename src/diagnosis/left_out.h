#pragma once
/// What a run says of the sensors that its verdict does not judge: wheels, barometer, two antennas, magnetometer.

#include <string>
#include <vector>

#include "piste/core/log.h"
#include "piste/core/solution.h"

namespace piste {

/// A line for each of them, and for the constraint of a vehicle, of whose measurements under way a fifth and more were
/// left out: how many, by how much they contradict the rest in the median, and what is to be looked at. The filter goes
/// on without them, so that the sigmas may hold all the same: without the line nobody would know.
std::vector<std::string> left_out_lines(const Log& log, const Solution& filtered);

}  // namespace piste
