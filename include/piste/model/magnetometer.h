#pragma once
/// Heading from a magnetometer: the azimuth of the field, turned into w, is the declination.

#include "piste/model/measurement.h"

namespace piste {

/// Azimuth [rad] of a field given in body axes, east of w's north.
double magnetic_azimuth(const Quaterniond& q_wb, const Vector3d& field_b);

/// One row: declination − azimuth, wrapped to ±π. `sigma` [rad].
Linearization linearize_magnetic_heading(const Vector3d& field_b, double declination, double sigma, const Estimate& x);

}  // namespace piste
