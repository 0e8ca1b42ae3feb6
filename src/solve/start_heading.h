#pragma once
// The attitude of a start whose heading somebody gives.

#include <optional>
#include <string>

#include "start_place.h"
#include "start_rest.h"

namespace piste {

/// Attitude at the start, the 1-sigma [rad] of its heading, and in words how it was found.
struct Pointing {
  Quaterniond q_wb;
  double sigma;
  std::string how;
};

/// From the first fix of the reference attitude, and from how b sits against it: as the rates of both tell, or else as
/// the boresight's prior says. Levelled by the rest where there is one.
/// Throws DataError where there is no reference attitude, or where gravity contradicts a boresight taken for small.
Pointing point_by_reference(const Log& log, const FilterOptions& options, const Start& start,
                            const std::optional<Rest>& rest);

/// From a heading that is given, or the magnetometer's. Level by the rest, or by an alignment in the first seconds of
/// motion, or by the mean force of the first second.
/// Throws DataError where the magnetometer is asked for and the log has none.
Pointing point_by_heading(const Log& log, const FilterOptions& options, const Receiver& receiver, const Start& start,
                          const InitialHeading& heading, const std::optional<Rest>& rest);

}  // namespace piste
