#pragma once
/// Finds how an IMU is mounted in a vehicle before the filter runs, from the motion alone.

#include <optional>

#include "piste/core/log.h"
#include "piste/core/options.h"
#include "piste/filter/initial_state.h"

namespace piste {

/// The options without a vehicle, its odometer and their blocks: the body moves as it likes.
FilterOptions without_vehicle(FilterOptions options);

/// A mounting q_vb and its 1-sigma about the axes of v [rad].
struct VehicleMounting {
  Quaterniond q_vb;
  Vector3d sigma;
  double forward = 1;  ///< part of the way that it went forward; below one half the axes would point backwards
};

/// Runs a filter without the vehicle from `start` until the motion has shown the mounting. Where the vehicle drives
/// faster than 5 m/s, its forward axis is the mean direction of the velocity in the body, weighted by how well the
/// filter knows it, and its down axis is on the mean that of the local level. So a vehicle is taken to drive forward
/// for the longer way. Returns nullopt if the log does not tell pitch and heading to 10 deg.
std::optional<VehicleMounting> find_vehicle_mounting(const Log& log, const FilterOptions& options, const Start& start);

/// The options with the mounting of their vehicle, and `start` with what is then known. A mounting that is not stated
/// is that of find_vehicle_mounting(), with loose sigmas, as the filter uses the same motion again. Does nothing
/// without a vehicle. Throws DataError if the motion does not tell the mounting.
FilterOptions with_mounting(FilterOptions options, const Log& log, Start& start);

}  // namespace piste
