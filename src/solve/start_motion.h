#pragma once
// A start whose heading nobody gives: it is found from the first stretch of motion that tells it.

#include <optional>

#include "piste/solve/start.h"
#include "start_place.h"
#include "start_rest.h"

namespace piste {

/// Aligns in the first motion that tells the whole attitude, filters and smooths a stretch from there, carries the
/// attitude back to `start.time` through the gyro, levels it by the rest where there is one, and filters and smooths a
/// second stretch from the start itself.
/// Throws DataError where no motion tells the heading.
FoundStart start_from_motion(const Log& log, const FilterOptions& options, const Receiver& receiver, Start start,
                             const std::optional<Rest>& rest);

}  // namespace piste
