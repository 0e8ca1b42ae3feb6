#pragma once
/// How much of a reference attitude's error is white.

#include "piste/core/log.h"
#include "piste/core/options.h"

namespace piste {

/// Sets `white` of every attitude source that has a drift, and leaves the drift's sigma the rest of the total.
///
/// What r turned by between two fixes, less what the gyro says, holds the white errors of both: n(k+1) − n(k). Two such
/// differences that share a fix have the covariance −σ², while noise and bias of the gyro, and the slow error of the
/// reference, have none. Fast turns, in which scale factors would tell, are left out. Between 10 % and all of the
/// fixes' sigma, and 10 % where there is too little to tell; level axes have one figure, the vertical its own.
void measure_white_part(const Log& log, FilterOptions& options);

}  // namespace piste
