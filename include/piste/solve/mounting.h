#pragma once
/// How the IMU sits against a reference attitude, before any filter has run: by any rotation.

#include <optional>

#include "piste/core/log.h"

namespace piste {

/// Boresight R_rb and its covariance [rad²], as in BoresightFromRates; gyro bias of b against r [rad/s].
struct Mounting {
  Quaterniond q_rb;
  Matrix3d covariance;
  Vector3d gyro_bias;
};

/// From what r turned by between its fixes, the Earth's turn with it, and what the gyro says that b turned by: both are
/// one rotation, on two sets of axes. Looks at the whole log, whose first source with fixes it takes; leaves gaps out.
/// nullopt where the motion does not determine it to 10 deg.
std::optional<Mounting> find_mounting(const Log& log);

}  // namespace piste
