#pragma once
/// What was learned of one IMU in one run, as a table for a terminal.

#include <string>

#include "piste/fit/imu_fit.h"

namespace piste {

/// Phases, and per axis the biases and scales with their total sigmas.
std::string findings_text(const Findings& findings);

}  // namespace piste
