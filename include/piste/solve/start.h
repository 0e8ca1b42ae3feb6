#pragma once
/// Where a run begins: position, velocity, level and heading at the start of the log.
///
/// With heading `auto` nothing is known of it: it is found from the first seconds of motion (model/alignment.h),
/// refined by filtering and smoothing a stretch from there, and carried back to the start through the gyros; a second
/// stretch, filtered and smoothed from the start, gives attitude and biases there, and the heading at the departure.
/// This looks ahead and is for replays; live, align_in_motion() over the last seconds gives the start.

#include <string>

#include "piste/solve/run.h"

namespace piste {

struct FoundStart {
  Start start;
  std::string how;  ///< one sentence for the report: which source, and when motion began
};

/// Throws DataError that says what was missing: fixes, motion, an attitude, a magnetic field.
FoundStart find_start(const Log& log, const FilterOptions& options, const InitialHeading& heading);

}  // namespace piste
