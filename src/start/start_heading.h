#pragma once
// The attitude of a start whose heading is given: by the reference attitude, the magnetometer or the configuration.

#include <optional>
#include <string>

#include "start/start_place.h"
#include "start/start_rest.h"

namespace piste {

/// Attitude at the start, the 1-sigma [rad] of its heading, and how it was found, in words.
struct Pointing {
  Quaterniond q_wb;
  double sigma;
  std::string how;
};

/// The attitude from the first fix of the reference attitude and the boresight. If the boresight is estimated, it is
/// found from the rates of both IMUs; if these do not determine it, it is taken to be small, as its prior says. If the
/// run starts at rest, roll and pitch come from the rest.
/// Throws DataError if there is no reference attitude, or if gravity contradicts a boresight that is taken to be small.
Pointing point_by_reference(const Log& log, const FilterOptions& options, const Receiver& receiver, const Start& start,
                            const std::optional<Rest>& rest);

/// The attitude with a given heading, or with that of the magnetometer. Roll and pitch come from the rest, or from an
/// alignment in the first seconds of motion, or from the mean specific force of the first second.
/// Throws DataError if the magnetometer is to be used and the log has none.
Pointing point_by_heading(const Log& log, const FilterOptions& options, const Receiver& receiver, const Start& start,
                          const InitialHeading& heading, const std::optional<Rest>& rest);

}  // namespace piste
