#pragma once
/// What an ensemble of runs says, in words for a terminal.

#include <string>

#include "piste/consistency/consistency.h"

namespace piste {

/// The verdict, then under way: NEES by group, RMSE over its bound of position, velocity and attitude, NIS by source.
/// A * stands behind what lies outside its band.
std::string consistency_text(const ConsistencyReport& report);

}  // namespace piste
