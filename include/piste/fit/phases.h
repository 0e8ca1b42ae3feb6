#pragma once
/// Finds the three phases of a run: rest, run, rest.

#include <vector>

#include "piste/core/aligned.h"
#include "piste/core/log.h"

namespace piste {

/// The phases of a log over `span` with the rests `rest`. Rests of at least 5 s separate stretches of motion; the run
/// is the longest stretch. The phases before and after it are the longest rest on each side. A log without such a rest
/// is a run as a whole; a log without motion has no run. @pre `rest` is in order
Phases phases(const std::vector<Interval>& rest, Interval span);

/// The phases of two aligned IMUs over all usable samples, with the rests of the reference (detect_rest). @pre the
/// signals have gone through a low-pass (low_passed), because otherwise no rest is found with a noisy reference
Phases phases(const AlignedImus& imus);

}  // namespace piste
