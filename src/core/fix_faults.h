#pragma once
/// What cannot be right of a fix, wherever it comes from: a log, or a receiver in real time.

#include <string>

#include "piste/core/log.h"

namespace piste {

/// What is wrong with a place, and what would be right; empty if nothing is.
std::string fault_of(const Geodetic& place);

/// Whether sigmas are above zero, and none is NaN. That of a velocity that was not measured is infinite.
bool are_sigmas(const Vector3d& sigma);

/// Of a fix whose numbers no reader has seen: the first that is wrong, or empty.
std::string fault_of(const GeodeticFix& fix);

}  // namespace piste
