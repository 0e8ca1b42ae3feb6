#pragma once
// A start without a given heading: the heading is found from the first motion that determines it.

#include <optional>
#include <vector>

#include "piste/start/start.h"
#include "start/start_place.h"
#include "start/start_rest.h"

namespace piste {

/// Starts with headings around the circle. That of a moving body is at the time `begin`; that of a stationary one is in
/// the last `listened` seconds before it departs.
std::vector<Start> heading_hypotheses(const Log& log, const FilterOptions& options, const Receiver& receiver,
                                      double begin);

/// Runs filters from these headings in parallel until the motion has excluded all but one (heading_search.h). The
/// stretch is then smoothed, which centres the attitude of the start. A stationary body gives no information on its
/// heading. So only the last seconds before it departs are filtered, and the gyroscopes carry the heading back to
/// `begin`. If several headings remain, the sigma of the start covers them.
/// Throws DataError if several headings remain and the body never departs.
FoundStart start_from_motion(const Log& log, const FilterOptions& options, const Receiver& receiver, double begin);

}  // namespace piste
