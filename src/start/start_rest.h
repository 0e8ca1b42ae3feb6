#pragma once
// What the rests of a log tell before the filter runs: mean rate and force, and the gyroscopes' bias.

#include <optional>

#include "piste/core/log.h"
#include "piste/core/options.h"

namespace piste {

/// A rest, or a part of it, with the mean rate and specific force in it, in body axes.
struct Rest {
  Interval interval;
  Vector3d mean_rate, mean_force;
};

/// The means of the samples of an interval. @pre it holds a sample
Rest average(const Log& log, const Interval& interval);

/// The rest at the time `t`: it begins and lasts as the options say. Only its first `longest_rest` seconds are taken.
std::optional<Rest> rest_at(const Log& log, double t, const StartOptions& options);

/// What is known of the gyroscopes' bias before the filter runs: value and 1-sigma [rad/s].
struct GyroBias {
  Vector3d value = Vector3d::Zero();
  double sigma = 0;
};

/// The gyroscopes' bias at the time `t`: the mean rate of the last rest that began `bias_rest` before `t` or earlier.
/// Without such a rest, zero with the sensor's turn-on sigma. The Earth's rate is not subtracted.
GyroBias bias_before(const Log& log, const FilterOptions& options, double t);

}  // namespace piste
