#pragma once
/// What must be known of a filtered run before anyone relies on it.

#include <string>
#include <vector>

#include "piste/core/solution.h"

namespace piste {

/// One sentence each: sources of which the gate rejected more than a fifth, which is too much for outliers; then the
/// stretches over which a receiver was not believed (disputes.h).
std::vector<std::string> warnings_of(const Solution& filtered);

}  // namespace piste
