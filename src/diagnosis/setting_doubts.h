#pragma once
/// What a configuration states that its logs contradict, or that changes nothing in them.

#include <string>
#include <vector>

#include "piste/core/log.h"
#include "piste/core/options.h"

namespace piste {

/// A line for each receiver whose coloured error is larger than the whole error that half of its fixes state, and for
/// each of the `outages` that is outside the log: what is stated, what the log has, and what would be right.
std::vector<std::string> setting_lines(const Log& log, const FilterOptions& options,
                                       const std::vector<Interval>& outages);

}  // namespace piste
