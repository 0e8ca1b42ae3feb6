#pragma once
/// A trajectory as KML, for Google Earth and similar programs.

#include <cstddef>
#include <string>

#include "piste/core/solution.h"

namespace piste {

/// A KML document with the track as a line of at most about `limit` points, and its start and end. Heights are above
/// the ellipsoid, while KML's `absolute` means above the sea. The track may therefore be off the ground by the
/// undulation of the geoid, and the document's description says so. An empty solution gives an empty document.
std::string kml(const Solution& solution, const std::string& name, std::size_t limit = 4000);

}  // namespace piste
