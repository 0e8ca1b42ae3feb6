#pragma once
/// The state with which a filter begins.

#include <optional>

#include "piste/core/estimate.h"
#include "piste/core/options.h"

namespace piste {

/// Time, estimate and covariance at the start. The covariance may be of the navigation blocks alone (9 × 9, order ρ, ν,
/// θ); the other blocks then begin as the state table says, and its position is that of the first receiver's antenna:
/// that of the IMU is less sure by attitude and lever arm. Or it is of the whole layout.
struct Start {
  double time = 0;
  Estimate x;
  Covariance covariance = Covariance::Identity(9, 9);
};

/// Sets what the options state of an estimate: the delays of the first sources, and mounting and contact of a vehicle.
/// Every start needs this: an estimated delay is a whole delay, not what remains beside the known one.
void set_known(Estimate& x, const FilterOptions& options);

/// The covariance of a start for all blocks of the layout. A constant block has its prior, a process its variance at
/// the start.
Covariance initial_covariance(const StateLayout& layout, const FilterOptions& options, const Start& start);

}  // namespace piste
