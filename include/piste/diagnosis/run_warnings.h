#pragma once
/// All that a run warns of.

#include <string>
#include <vector>

#include "piste/core/log.h"
#include "piste/core/options.h"
#include "piste/core/solution.h"

namespace piste {

/// A sentence for each: receivers that were left out for a while (warnings_of()), sensors that contradict the rest,
/// first fixes that the later ones contradict, several IMUs that do not turn alike, and what the configuration states
/// that its logs contradict or that withholds nothing. `outages`: those of the configuration.
std::vector<std::string> run_warnings(const Log& log, const FilterOptions& options, const Solution& filtered,
                                      const std::vector<Interval>& outages = {});

}  // namespace piste
