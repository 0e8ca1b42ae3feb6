#pragma once
/// The file `summary.json` of a replay.

#include <string>

#include "piste/consistency/verdict.h"
#include "piste/core/log.h"
#include "piste/core/solution.h"

namespace piste {

/// Times that the replay took [s].
struct RunTimes {
  double cpu = 0, wall = 0;
};

/// `summary.json`. Its members mean:
///  - `estimates`: the values at the last epoch of `smoothed`, or of `filtered` if there is none. `gyro_total_bias`
///   and `accel_total_bias` are bias + drift averaged over the epochs of the run: the mean of the values, and the mean
///   of the sigmas.
///  - `attitude_error`: the rms over the epochs of the sigmas of roll, pitch and heading, and the correlation time of
///   their errors. It is null if it is unknown, as without a smoother.
///  - `used` and `rejected`: numbers of fixes. A fix of which any part was rejected counts as rejected. `sources`
///   counts each part.
///  - `verdict`: consistency/verdict.h. Of each source `nis`, `rejected` (a share), and what else is known; `nis` is
///   null where there were too few fixes. `jumps` of the constants that went furthest from their priors, in prior
///   sigmas.
///
/// Everything except `cpu_s` and `wall_s` is the same at every replay.
std::string summary_json(const Log& log, const Solution& filtered, const Solution* smoothed, const Verdict& verdict,
                         const RunTimes& times);

}  // namespace piste
