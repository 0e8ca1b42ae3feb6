#pragma once
/// Finds the mounting of an IMU in a vehicle from the motion alone, before the filter runs.

#include <optional>

#include "piste/core/log.h"
#include "piste/core/options.h"
#include "piste/filter/initial_state.h"

namespace piste {

/// The options without a vehicle, its odometer and their blocks: the motion of the body is not constrained.
FilterOptions without_vehicle(FilterOptions options);

/// A mounting q_vb and its 1-sigma about the axes of v [rad].
struct VehicleMounting {
  Quaterniond q_vb;
  Vector3d sigma;
  double forward = 1;  ///< fraction of the distance that it drove forward; at least one half, by the choice of axes
};

/// Runs a filter without the vehicle from `start` until the motion has determined the mounting. Only velocities above
/// 5 m/s are used. The forward axis is the mean direction of the velocity in the body, weighted by the filter's
/// accuracy. The down axis is on average that of the local level. A vehicle is thus taken to drive forward for the
/// longer distance. Returns nullopt if the log does not determine pitch and heading to 10 deg.
std::optional<VehicleMounting> find_vehicle_mounting(const Log& log, const FilterOptions& options, const Start& start);

/// The options with the mounting of their vehicle; `start` gets the values that are then known (set_known()). A
/// mounting that is not stated is that of find_vehicle_mounting(), with loose sigmas, as the filter uses the same
/// motion again. Does nothing without a vehicle. Throws DataError if the motion does not determine the mounting.
FilterOptions with_mounting(FilterOptions options, const Log& log, Start& start);

}  // namespace piste
