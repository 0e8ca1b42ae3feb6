#pragma once
/// The first fixes of a receiver, where the later ones contradict them: a false ambiguity, or a place of the day
/// before.

#include <vector>

#include "piste/core/behaviour.h"
#include "piste/core/log.h"

namespace piste {

/// A run begins at its first fixes, and later fixes that contradict them are taken for the receiver's error. If the
/// positions leap, and stay elsewhere for three times as long as at the beginning, the first fixes are taken to be
/// wrong. This is tested within twice the longest exclusion of a receiver. The sigmas of the first fixes then grow so
/// that the sigma of their mean is its error.
FirstFixes widen_first_fixes(std::vector<GnssFix>& fixes, const FaultDetectionOptions& options, const World& world);

}  // namespace piste
