#pragma once
/// Where a run begins: position, velocity, level and heading at the start of the log.
///
/// With heading `auto` nothing is known of the heading. It is found from the first seconds of motion
/// (model/alignment.h), refined by filtering and smoothing a stretch from there, and carried back to the start through
/// the gyros. A second stretch, filtered and smoothed from the start, gives attitude and biases there, and the heading
/// at the departure. This looks ahead and serves replays; live, align_in_motion() over the last seconds gives the
/// start.

#include <string>

#include "piste/solve/run.h"

namespace piste {

/// A start, and where it comes from.
struct FoundStart {
  Start start;
  std::string how;  ///< one sentence for the report: which source, and when motion began
};

/// The start of a log, its heading as `heading` asks. Throws DataError where something is missing, and says what: IMU
/// samples, fixes, motion, a reference attitude, or a magnetic field.
FoundStart find_start(const Log& log, const FilterOptions& options, const InitialHeading& heading);

}  // namespace piste
