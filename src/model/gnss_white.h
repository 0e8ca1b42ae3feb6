#pragma once
/// The white part of a receiver's position error.

#include <optional>

#include "piste/core/log.h"
#include "piste/core/options.h"

namespace piste {

/// A square root of the covariance of the white part of a position, along n [m]: the total less the slow part. After an
/// increase of the stated sigmas the slow part has not grown yet, and the white part is larger.
///
///     const Matrix3d white = white_factor(fix, {});  // white * white.transpose() is the whole covariance
Matrix3d white_factor(const GnssFix& fix, const std::optional<PositionDrift>& drift);

}  // namespace piste
