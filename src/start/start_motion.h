#pragma once
// A start whose heading is not given: it is found from the first motion that determines it.

#include <optional>
#include <vector>

#include "piste/start/start.h"
#include "start/start_place.h"
#include "start/start_rest.h"

namespace piste {

/// Starts with headings around the circle, of a body that stands (until it departs) or moves at the time `begin`.
std::vector<Start> heading_hypotheses(const Log& log, const FilterOptions& options, const Receiver& receiver,
                                      double begin);

/// Filters from these headings side by side until the motion has left one (heading_search.h), and smooths that stretch,
/// which centres the attitude of the start. Before the departure a body at rest tells nothing of its heading: then only
/// the last seconds of the rest are filtered, and the heading is carried back to `begin` by the gyroscopes.
/// Where the motion leaves several headings, the start claims what lies between them.
/// Throws DataError if the body never moves.
FoundStart start_from_motion(const Log& log, const FilterOptions& options, const Receiver& receiver, double begin);

}  // namespace piste
