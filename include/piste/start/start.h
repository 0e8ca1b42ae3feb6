#pragma once
/// Finds the start of a run: position, velocity, attitude and their covariance at the beginning of the log.
///
/// With heading `auto` a multiple-model search finds the heading in the first motion (src/start/heading_search.h), and
/// the attitude is carried back to the beginning of the log by the gyroscopes. This looks ahead in the log. A program
/// in real time uses `Live` (live.h) instead.

#include <optional>
#include <string>

#include "piste/filter/run.h"

namespace piste {

/// A start, and how it was found.
struct FoundStart {
  Start start;
  std::string how;  ///< a sentence for the report
  /// Time at which the heading was sure, if the motion showed it. A filter knows it only from then on; what it says of
  /// the time before is better said by a smoother that looks back from there.
  std::optional<double> aligned = std::nullopt;
};

/// The start without what the motion showed of its attitude: for a solver of the whole run, which uses that motion
/// itself.
Start without_alignment(const World& world, const FoundStart& found);

/// Finds the start of a log, with the heading from the source that `heading` names. Throws DataError that says what is
/// missing: IMU samples, fixes, motion, a reference attitude, or a magnetic field.
FoundStart find_start(const Log& log, const FilterOptions& options, const InitialHeading& heading);

}  // namespace piste
