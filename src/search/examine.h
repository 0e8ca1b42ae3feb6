#pragma once
/// Reads a log, and examines it by itself.

#include <vector>

#include "piste/inspect/inspection.h"

namespace piste {

/// Fills in the rows of `log` and their health, as its guess says what it is. What looks wrong goes to `found`; what
/// cannot be read as guessed loses its guess.
void examine(InspectedLog& log, std::vector<Suspicion>& found);

}  // namespace piste
