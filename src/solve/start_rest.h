#pragma once
// What the rests of a log say before the filter runs.

#include <optional>

#include "piste/core/log.h"
#include "piste/core/options.h"
#include "piste/model/alignment.h"

namespace piste {

/// A rest, or a part of it, and what the IMU reads there on average, body axes.
struct Rest {
  Interval interval;
  Vector3d mean_rate, mean_force;
};

/// The means of the samples of an interval. @pre it holds a sample
Rest average(const Log& log, const Interval& interval);

/// The rest that lasts from `t`, give or take half a second, for a second or more; at most its first `longest` seconds.
std::optional<Rest> rest_at(const Log& log, double t, double longest);

/// The gyro's bias as the last rest that began 2 s before `t` or earlier shows it; without one, zero with the sensor's
/// turn-on sigma. The rate of the Earth is left in it.
GyroBias bias_before(const Log& log, const FilterOptions& options, double t);

}  // namespace piste
