#pragma once
/// Warnings about a filtered run that a user must know before relying on it.

#include <string>
#include <vector>

#include "piste/core/solution.h"

namespace piste {

/// One sentence for each source of which the gate rejected more than a fifth, which is too many to be outliers; then
/// one for each dispute (disputes.h).
std::vector<std::string> warnings_of(const Solution& filtered);

}  // namespace piste
