#pragma once
/// Finds the rotation between the IMU and a reference attitude, of any size, before the filter runs.

#include <optional>
#include <span>

#include "piste/core/log.h"
#include "piste/core/options.h"

namespace piste {

/// Boresight R_rb and its covariance [rad²], as in BoresightFromRates; gyro bias of b relative to r [rad/s].
struct Mounting {
  Quaterniond q_rb;
  Matrix3d covariance;
  Vector3d gyro_bias;
};

/// Compares the rotation of r between two of its fixes, with the Earth's rotation added, with the rotation of b by the
/// gyroscopes. Both are the same rotation in two sets of axes. Uses the whole log without its gaps, and the first
/// attitude source that has fixes. `sources` are the options of all, which state their delays. Returns nullopt if the
/// motion does not determine the boresight to 10 deg (1-sigma).
std::optional<Mounting> find_mounting(const Log& log, std::span<const AttitudeOptions> sources = {});

}  // namespace piste
