#pragma once
/// The first fixes of a receiver, where the later ones contradict them: a false ambiguity, or a place of the day
/// before.

#include <vector>

#include "piste/core/behaviour.h"
#include "piste/core/log.h"

namespace piste {

/// A run begins where its first fixes are, and what contradicts them later is taken for the receiver's error. So if the
/// positions leap, and are then elsewhere for three times as long as they were where they began, as far as twice the
/// time for which a receiver is distrusted goes, the first ones are, in the mean, as uncertain as they are off: their
/// sigmas grow by that.
FirstFixes widen_first_fixes(std::vector<GnssFix>& fixes, const TrustOptions& options, const World& world);

}  // namespace piste
