#pragma once
/// Checks of a fix for impossible numbers, from a log or from a receiver in real time.

#include <string>

#include "piste/core/log.h"

namespace piste {

/// The fault of a position, and what would be right; empty if there is none.
std::string fault_of(const Geodetic& place);

/// Whether sigmas are above zero, and none is NaN. That of a velocity that was not measured is infinite.
bool are_sigmas(const Vector3d& sigma);

/// For a fix that no reader has checked: the first fault, or empty.
std::string fault_of(const GeodeticFix& fix);

}  // namespace piste
