#pragma once
/// Warnings about a filtered run that a user must know before relying on it.

#include <string>
#include <vector>

#include "piste/core/solution.h"

namespace piste {

/// One sentence for each dispute of a GNSS receiver (disputes.h). Whether the sigmas hold is told by verdict.h.
std::vector<std::string> warnings_of(const Solution& filtered);

/// What an adapting filter took the noise to be, in one line. @pre it adapted
std::string adapted_line(const AdaptedNoise& adapted);

/// How a batch went, in a line.
std::string batch_line(const BatchSummary& batch);

}  // namespace piste
