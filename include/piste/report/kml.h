#pragma once
/// A trajectory for Google Earth and its kin.

#include <cstddef>
#include <string>

#include "piste/core/solution.h"

namespace piste {

/// KML document with the track as a line of at most about `limit` points, and its start and end. Heights are above
/// the ellipsoid, where KML's `absolute` means above the sea: the track may hang off the ground by the undulation
/// of the geoid, and the document's description says so. An empty solution gives an empty document.
std::string kml(const Solution& solution, const std::string& name, std::size_t limit = 4000);

}  // namespace piste
