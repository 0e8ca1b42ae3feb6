#pragma once
/// The text of an ensemble for a terminal.

#include <string>

#include "piste/consistency/consistency.h"

namespace piste {

/// The verdict; then, for the time under way, NEES by group, RMSE / bound of position, velocity and attitude, and NIS
/// by source. A * marks a value outside its band.
std::string consistency_text(const ConsistencyReport& report);

}  // namespace piste
