#pragma once
/// Rest, run, rest.

#include <vector>

#include "piste/core/aligned.h"
#include "piste/core/log.h"

namespace piste {

/// Phases of a log over `span` that stood still in the intervals `rest`, in order. A rest of five seconds parts two
/// runs; the run is the longest, and before and after it lies the longest rest each. A log without such a rest is all
/// run, one that never moves has none.
Phases phases(const std::vector<Interval>& rest, Interval span);

/// Of two IMUs, over all that is usable, from where the reference stands still (detect_rest). Signals as they went
/// through a low-pass (low_passed), without which a noisy reference does not rest.
Phases phases(const AlignedImus& imus);

}  // namespace piste
