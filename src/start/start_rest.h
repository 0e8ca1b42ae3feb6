#pragma once
// Results of standstill before the filter runs: mean rate and specific force, and the bias of the gyroscopes.

#include <optional>

#include "piste/core/log.h"
#include "piste/core/options.h"

namespace piste {

/// A rest, or a part of it, with the mean rate and specific force in it, in body axes.
struct Rest {
  Interval interval;
  Vector3d mean_rate, mean_force;
};

/// The means over the samples of an interval. @pre It holds a sample.
Rest average(const Log& log, const Interval& interval);

/// The rest at the time `t`, if one begins and lasts as the options require. Only its first `longest_rest` seconds are
/// used.
std::optional<Rest> rest_at(const Log& log, double t, const StartOptions& options);

/// The bias of the gyroscopes that is known before the filter runs: value and 1-sigma [rad/s].
struct GyroBias {
  Vector3d value = Vector3d::Zero();
  double sigma = 0;
};

/// The gyroscopes' bias at the time `t`: the mean rate of the last rest that began at least `bias_rest` seconds before
/// `t`. Without such a rest it is zero, with the sensor's turn-on sigma. The Earth's rate is not subtracted.
GyroBias bias_before(const Log& log, const FilterOptions& options, double t);

}  // namespace piste
