#pragma once
/// The results of `allan` for a terminal.

#include <string>

#include "piste/recordings/allan.h"

namespace piste {

/// A table of the axes, the sensor file's remarks, and warnings.
std::string allan_text(const AllanFindings& findings);

/// A number with its interval in a unit, such as `0.0123 (0.0119 to 0.0128) deg/s`.
std::string interval_text(const Measured& m, double factor, const std::string& unit);

}  // namespace piste
