#pragma once
/// What the scales of a unit do across the axes of the first, where it is turned by other than right angles.

#include <vector>

#include "condition/unit_differences.h"
#include "condition/unit_samples.h"
#include "piste/core/sensor.h"

namespace piste {

/// A triad of a unit that is turned into the axes of the first.
struct TurnedTriad {
  UnitTriad& samples;
  const TriadErrors& errors;
  const Matrix3d& R;  ///< from the axes of the unit's sensor to those of the first
};

/// Scales s act along the axes of a sensor; along those of the first they are R diag(s) Rᵀ, of which the mean of the
/// units and their parities know the diagonal only. This takes the rest off the unit's samples. s is found by a Kalman
/// filter over the windows, from what the unit differs by from the first: an offset that drifts as the two do, R
/// diag(s) Rᵀ u, and the scales of the first along its own axes. What the motion does not tell stays near zero by the
/// sensors' 1-sigmas. Returns the matrix C of which C y was taken off the outputs y: of right angles nothing.
/// @pre As combine().
Matrix3d take_out_cross_axis(const UnitTriad& first, const TriadErrors& of_first, const TurnedTriad& unit,
                             const std::vector<double>& intervals, const std::vector<UnitWindow>& windows);

}  // namespace piste
