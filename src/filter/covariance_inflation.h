#pragma once
/// Covariance inflation when the filter uses a fix from outside its gate: the error exceeded its covariance.

#include "piste/core/behaviour.h"
#include "piste/model/measurement.h"

namespace piste {

/// Adds to P the errors that explain the residual: of the navigation, or, where several IMUs part, of their drifts.
/// `lapse` [s] is the time since a fix of the source was last used. Within it an error in velocity grows into one in
/// position, and a tilt into one in velocity. It is infinite if no fix of the source was used before: the error is then
/// that of the start.
void inflate_covariance(Covariance& P, const StateLayout& layout, const Linearization& lin, double lapse,
                        const FaultDetectionOptions& options);

}  // namespace piste
