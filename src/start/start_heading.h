#pragma once
// The attitude at the start where its heading is given: by a reference attitude, a magnetometer or the configuration.

#include <optional>
#include <string>

#include "start/start_place.h"
#include "start/start_rest.h"

namespace piste {

/// Attitude at the start, 1-sigma of its heading [rad], and its source in words.
struct Pointing {
  Quaterniond q_wb;
  double sigma;
  std::string how;
};

/// The attitude from the first fix of the reference attitude and the boresight. If the boresight is estimated, it is
/// found from the rates of both IMUs. If these do not determine it, it is taken to be small, as its prior states. If
/// the run starts at standstill, roll and pitch come from levelling.
/// Throws DataError if there is no reference attitude, or if gravity contradicts a boresight that is taken to be small.
Pointing point_by_reference(const Log& log, const FilterOptions& options, const Receiver& receiver, const Start& start,
                            const std::optional<Rest>& rest);

/// The attitude with a given heading, or with that of the magnetometer. Roll and pitch come from levelling at
/// standstill, or else from the first seconds of motion (start_on_the_move()).
/// Throws DataError if the magnetometer is to be used and the log has none, or if its field is zero or has a wrong dip.
Pointing point_by_heading(const Log& log, const FilterOptions& options, const Receiver& receiver, const Start& start,
                          const InitialHeading& heading, const std::optional<Rest>& rest);

}  // namespace piste
