#pragma once
/// The Earth's magnetic field by the World Magnetic Model 2025, whose coefficients ship with the library
/// (config/wmm2025). GeographicLib sums the spherical harmonics.

#include "piste/math/earth.h"

namespace piste {

/// The years for which the model holds.
inline constexpr double kMagneticFirstYear = 2025, kMagneticLastYear = 2030;

/// The field at a place in a year, such as 2026.5, along north, east, down of the ellipsoid [µT]. Source: Chulliat et
/// al. 2025, The US/UK World Magnetic Model for 2025-2030, equations 4 to 12. The model's error is 0.09 to 0.14 µT per
/// axis (1-sigma), nearly all of it from the crust. Outside the model's years the field is extrapolated.
Vector3d magnetic_field(const Geodetic& place, double year);

}  // namespace piste
