#pragma once
/// Covariance inflation when the filter uses a fix outside its gate: the filter's error exceeded its covariance.

#include "piste/core/behaviour.h"
#include "piste/model/measurement.h"

namespace piste {

/// Adds to P the errors that explain the residual: those of the navigation, or of the drifts where several IMUs
/// disagree. `lapse` [s] is the time since a fix of the source was last used. Within it an error in velocity grows into
/// one in position, and a tilt into one in velocity. `lapse` is infinite if no fix of the source was used before: the
/// error is then one of the initial state.
void inflate_covariance(Covariance& P, const StateLayout& layout, const Linearization& lin, double lapse,
                        const FaultDetectionOptions& options);

}  // namespace piste
