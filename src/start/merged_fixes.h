#pragma once
// Fixes of a standstill, averaged, so that a long rest before the start costs little.

#include "piste/core/log.h"

namespace piste {

/// The log until `end`, with the fixes of each receiver at rest averaged over `step` seconds. A stationary body has one
/// place, so that n fixes with independent errors are worth one at their weighted mean. A fix that is known to be at
/// fault, or of another kind, stays alone. Example: a receiver at 10 Hz, 20 min of rest and a step of 1 s leave 1200 of
/// 12 000 fixes.
Log with_merged_fixes(const Log& log, double end, double step);

}  // namespace piste
