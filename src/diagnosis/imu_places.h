#pragma once
/// The place of an IMU relative to another one, from the specific force that the rotation of the body adds.

#include <optional>

#include "diagnosis/imu_outputs.h"

namespace piste {

/// The offset p of an IMU from the place that its lever arm states, in b [m], and its 1-sigma. It is fitted to
/// f_i − f_1 = ([ω']× + [ω]×²) p, together with a bias and a matrix of scales and small rotations that acts on f_1.
/// It is a rough value, as ω is a mean over a window.
struct ImuOffset {
  Vector3d value, sigma;
};

/// Nothing where too few windows have neighbours on both sides, from which ω' follows.
std::optional<ImuOffset> imu_offset(const ImuOutputs& forces, std::size_t imu);

}  // namespace piste
