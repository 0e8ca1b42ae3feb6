#pragma once
/// Finds the start of a run: position, velocity, attitude and their covariance at the beginning of the log.
///
/// With heading `auto`, a multiple-model search finds the heading from the first motion (src/start/heading_search.h).
/// The gyroscopes carry the attitude back to the beginning of the log. This looks ahead in the log: a real-time program
/// uses `Live` (live.h) instead.

#include <optional>
#include <string>

#include "piste/filter/run.h"

namespace piste {

/// A start, and how it was found.
struct FoundStart {
  Start start;
  std::string how;  ///< a sentence for the report
  /// End of the motion from which the heading was found: the end of the heading search plus StartOptions::look_back.
  /// Nothing if the motion did not determine it. A filter knows the heading only from then on; earlier rows need
  /// back-smoothing.
  std::optional<double> aligned = std::nullopt;
};

/// The start with an uninformative prior of the attitude, if the motion determined it. A solver of the whole run needs
/// it, because it uses that motion itself.
Start without_alignment(const World& world, const FoundStart& found);

/// Finds the start of a log, with the heading from the given source. Throws DataError that names what is missing: IMU
/// samples, fixes, motion, a reference attitude, or a magnetic field.
FoundStart find_start(const Log& log, const FilterOptions& options, const InitialHeading& heading);

}  // namespace piste
