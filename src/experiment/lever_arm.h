#pragma once
/// Where the antenna sits, as the motion tells it.

#include "piste/core/log.h"
#include "piste/core/options.h"
#include "piste/inspect/inspection.h"

namespace piste {

/// Runs the filter over at most the first five minutes of the log, from the start that the motion gives, with the first
/// receiver's lever arm among the states: the start value that of the options, its sigma 2 m. Throws DataError where no
/// start is found.
LeverArmGuess lever_arm(const Recording& recording, const ConditioningOptions& conditioning, FilterOptions options);

}  // namespace piste
