#pragma once
/// The initial state of a filter.

#include <optional>

#include "piste/core/estimate.h"
#include "piste/core/options.h"

namespace piste {

/// Time, estimate and covariance at the start. The covariance is that of the whole layout, or of the navigation blocks
/// alone (9 × 9, order ρ, ν, θ). In the latter case the other blocks have their initial variance from the state table.
/// Its position is then that of the first receiver's antenna: the IMU's is less certain by attitude and lever arm.
struct Start {
  double time = 0;
  Estimate x;
  Covariance covariance = Covariance::Identity(9, 9);
};

/// Sets the values of an estimate that the options state: the delays of the first sources, and mounting and contact of
/// a vehicle. Every start needs this: an estimated delay is the whole delay, not the remainder beyond the known one.
void set_known(Estimate& x, const FilterOptions& options);

/// The initial covariance of all blocks of the layout. A constant block has its prior, a process its initial variance.
Covariance initial_covariance(const StateLayout& layout, const FilterOptions& options, const Start& start);

}  // namespace piste
