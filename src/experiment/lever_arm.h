#pragma once
/// Estimates the lever arm from the motion.

#include "piste/core/log.h"
#include "piste/core/options.h"
#include "piste/inspect/inspection.h"

namespace piste {

/// Estimates the lever arm of the first receiver: runs the filter over at most the first five minutes of the log, with
/// the lever arm among the states. Its start value is that of the options, with a sigma of 2 m. Throws DataError if no
/// start is found.
LeverArmGuess lever_arm(const Recording& recording, const ConditioningOptions& conditioning, FilterOptions options);

}  // namespace piste
