#pragma once
/// What a filter that was wrong admits when it takes a fix from outside its gate.

#include "piste/model/measurement.h"

namespace piste {

/// Adds to the navigation part of P the errors that would explain the residual: one of position grows out of one of
/// velocity over the `lapse` [s] since the source was last believed, and that out of a tilt; where it never was
/// (infinite), the error is the start's own.
void admit_error(Covariance& P, const StateLayout& layout, const Linearization& lin, double lapse);

}  // namespace piste
