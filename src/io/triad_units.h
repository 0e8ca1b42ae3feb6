#pragma once
/// The units in which files show the errors of gyroscopes and accelerometers.

#include <string_view>

#include "piste/math/units.h"

namespace piste {

/// Dimensions of one triad, and the units that a written file shows them in.
struct TriadUnits {
  Dimension value, noise, drift;
  std::string_view value_unit, noise_unit, drift_unit;
};

inline constexpr TriadUnits kGyroUnits{dimension::kAngularRate, dimension::kGyroNoise, dimension::kGyroDrift, "deg/s",
                                       "deg/s/sqrt(Hz)",        "deg/s^2/sqrt(Hz)"};
inline constexpr TriadUnits kAccelUnits{
    dimension::kAcceleration, dimension::kAccelNoise, dimension::kAccelDrift, "m/s^2", "ug/sqrt(Hz)", "m/s^3/sqrt(Hz)"};

}  // namespace piste
