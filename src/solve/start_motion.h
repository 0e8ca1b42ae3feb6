#pragma once
// A start whose heading is not given: it is found from the first motion that determines it.

#include <optional>

#include "piste/solve/start.h"
#include "start_place.h"
#include "start_rest.h"

namespace piste {

/// Aligns in the first motion that determines the whole attitude, and filters and smooths a stretch from there. Carries
/// the attitude back to `start.time` by the gyroscopes, takes roll and pitch from the rest if there is one, and filters
/// and smooths a second stretch from the start itself.
/// Throws DataError if no motion determines the heading.
FoundStart start_from_motion(const Log& log, const FilterOptions& options, const Receiver& receiver, Start start,
                             const std::optional<Rest>& rest);

}  // namespace piste
