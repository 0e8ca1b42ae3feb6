#pragma once
/// The errors of a reference attitude: how large they are, and how much of them is white noise.

#include <vector>

#include "piste/core/log.h"
#include "piste/core/options.h"

namespace piste {

/// Sets the size of the coloured error: returns `options` in which every attitude source with a drift has the rms of
/// its fixes' sigmas as the drift's sigma. This is the total error; `with_white_part` later subtracts the white part.
/// North and east get the same value, because roll and pitch turn with the body between north and east.
FilterOptions with_attitude_sigmas(FilterOptions options, const std::vector<AttitudeRecording>& attitude);

/// Measures the white part: returns `options` in which every attitude source with a drift has its `white` from the log,
/// and the rest of the total error as the drift's sigma.
///
/// Between two fixes the reference turns by some rotation, and so do the gyroscopes. The difference of the two contains
/// the white errors of both fixes, n(k+1) − n(k). Two successive differences share a fix, so their covariance is −σ²,
/// whereas noise and bias of the gyroscopes and the slow error of the reference do not correlate them. Fast turns are
/// left out, because scale factors would matter there. The white part is at least 10 % and at most all of the fixes'
/// sigma. It is 10 % if there is too little data. Where the delay of the reference is to be estimated, the one for
/// which the rotations agree best is used here. North and east have one value, down has its own.
FilterOptions with_white_part(FilterOptions options, const Log& log);

}  // namespace piste
