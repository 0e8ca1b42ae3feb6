#pragma once
/// Finds the start of a run: position, velocity, attitude and their covariance at the beginning of the log.
///
/// With heading `auto` the heading may be unknown. Then
///  1. it is found from the first seconds of motion (model/alignment.h);
///  2. a stretch is filtered and smoothed from there, which refines it;
///  3. the attitude is carried back to the beginning of the log by the gyroscopes;
///  4. a second stretch is filtered and smoothed from the beginning. It gives attitude and biases there, and the
///   heading at the departure.
///
/// This looks ahead in the log. A program in real time uses align_in_motion() over the last seconds instead.

#include <string>

#include "piste/solve/run.h"

namespace piste {

/// A start, and how it was found.
struct FoundStart {
  Start start;
  std::string how;  ///< a sentence for the report
};

/// Finds the start of a log, with the heading from the source that `heading` names. Throws DataError that says what is
/// missing: IMU samples, fixes, motion, a reference attitude, or a magnetic field.
FoundStart find_start(const Log& log, const FilterOptions& options, const InitialHeading& heading);

}  // namespace piste
