#pragma once
/// A trajectory as KML, for Google Earth and similar programs.

#include <cstddef>
#include <optional>
#include <string>

#include "piste/core/solution.h"

namespace piste {

/// A KML document with the track as a line of at most about `limit` points, and its start and end. Heights are above
/// the geoid EGM96, as KML's `absolute` means; if there is no geoid (math/geoid.h), they are above the ellipsoid, and
/// the description says so. With the GPS week of the run the track is a `gx:Track` with times in UTC, else a LineString
/// without dates. An empty solution gives an empty document.
std::string kml(const Solution& solution, const std::string& name, std::optional<int> week = {},
                std::size_t limit = 4000);

}  // namespace piste
