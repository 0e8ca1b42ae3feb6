#pragma once
/// Fewer IMU samples for runs that compare hypotheses: the covariance of a filter costs as much for each of them.

#include "piste/core/log.h"

namespace piste {

/// The log with sums of adjoining samples in place of the samples, in groups of one size. A group ends at a rest's
/// beginning or end, at a gap, and at what was interpolated or clipped. Attitude and velocity over a group stay those
/// of the single samples: what coning and sculling within it add is in the sums.
///
/// The size is that for which second differences of the mean rates are least, as their noise falls with it and the
/// change of the motion within a group grows; no group is longer than 0.1 s.
///
///     thinned(log)  // 100 Hz on skis → groups of 2; of a car → groups of 10
Log thinned(const Log& log);

}  // namespace piste
