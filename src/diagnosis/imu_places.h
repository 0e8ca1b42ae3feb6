#pragma once
/// Where an IMU sits beside another one, by what the rotation of the body adds to its specific force.

#include <optional>

#include "diagnosis/imu_outputs.h"

namespace piste {

/// p: how far a unit is from where its lever arm puts it, in b [m], and 1-sigma of it. From f_i − f_1 = ([ω']× + [ω]×²)
/// p, with a bias, and a matrix of scales and small rotations that acts on f_1, fitted beside. Only roughly: ω is a
/// mean over a window.
struct ImuOffset {
  Vector3d value, sigma;
};

/// Nothing where too little of the log has neighbours from which ω' follows.
std::optional<ImuOffset> imu_offset(const ImuOutputs& forces, std::size_t unit);

}  // namespace piste
