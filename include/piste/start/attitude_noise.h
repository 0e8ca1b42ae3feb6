#pragma once
/// The errors of a reference attitude: their size, and the part of them that is white noise.

#include <vector>

#include "piste/core/log.h"
#include "piste/core/options.h"

namespace piste {

/// Sets the size of the coloured error. In the returned options the drift of every attitude source that has one gets
/// the rms of its fixes' sigmas as its sigma. This is the total error; with_white_part() later subtracts the white
/// part. North and east get the same value, because roll and pitch turn with the body between north and east.
FilterOptions with_attitude_sigmas(FilterOptions options, const std::vector<AttitudeRecording>& attitude);

/// Estimates the white part. In the returned options every attitude source with a drift has its `white` from the log.
/// The drift's sigma is the remainder of the total error.
///
/// Between two fixes the reference turns by some rotation, and so do the gyroscopes. The difference of the two contains
/// the white errors of both fixes, n(k+1) − n(k). Two successive differences share a fix, so their covariance is −σ².
/// Noise and bias of the gyroscopes, and the slow error of the reference, do not correlate them. Fast turns are
/// excluded, because scale factors would matter there.
///
/// The white part is at least 10 % and at most all of the fixes' sigma. With too little data it stays as configured;
/// the default is 10 %. Where the delay of the reference is estimated, the delay for which the rotations agree best is
/// used here. North and east have one value, down has its own.
FilterOptions with_white_part(FilterOptions options, const Log& log);

}  // namespace piste
