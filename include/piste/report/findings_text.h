#pragma once
/// The errors of one IMU in one run, as a table for a terminal.

#include <string>

#include "piste/fit/imu_fit.h"

namespace piste {

/// The phases, and for each axis the biases and scales with their total sigmas.
std::string findings_text(const Findings& findings);

}  // namespace piste
