#pragma once
/// What a replay came to, as a file: `summary.json`.

#include <string>

#include "piste/core/log.h"
#include "piste/core/solution.h"

namespace piste {

/// What `summary.json` tells beyond the solution.
struct RunTimes {
  double cpu = 0, wall = 0;
};

/// `summary.json`. `estimates` are the values at the last epoch of `smoothed` where there is one, else of `filtered`.
/// `gyro_total_bias` and `accel_total_bias` are bias + drift averaged over the run's epochs: the mean of the values,
/// and the mean of the sigmas. `attitude_error`: rms over the epochs of the sigmas of roll, pitch and heading, and the
/// correlation time of their errors, null where it is not known, as without a smoother. `used` and `rejected` count
/// fixes, and a fix of which any part was rejected is a rejected one; `sources` counts each part. All but `cpu_s` and
/// `wall_s` is the same at every replay.
std::string summary_json(const Log& log, const Solution& filtered, const Solution* smoothed, const RunTimes& times);

}  // namespace piste
