#pragma once
/// What is known of a reference attitude's errors: how large they are, and how much of them is white.

#include <vector>

#include "piste/core/log.h"
#include "piste/core/options.h"

namespace piste {

/// The options with the rms of its fixes' sigmas as the drift sigma of every attitude source that has a drift: the
/// total, until `with_white_part` takes the white part off. Level axes have one figure, as roll and pitch turn with the
/// body between north and east.
FilterOptions with_attitude_sigmas(FilterOptions options, const std::vector<AttitudeRecording>& attitude);

/// The options with `white` of every attitude source that has a drift, and the rest of its total as the drift's sigma.
///
/// What r turned by between two fixes, less what the gyro says, holds the white errors of both: n(k+1) − n(k). Two such
/// differences that share a fix have the covariance −σ², while noise and bias of the gyro, and the slow error of the
/// reference, have none. Fast turns, in which scale factors would tell, are left out. Between 10 % and all of the
/// fixes' sigma, and 10 % where there is too little to tell; level axes have one figure, the vertical its own.
FilterOptions with_white_part(FilterOptions options, const Log& log);

}  // namespace piste
