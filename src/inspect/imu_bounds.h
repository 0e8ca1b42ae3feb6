#pragma once
/// Bounds that both the examination of an IMU's log and the texts about it use.

namespace piste {

inline constexpr double kFastRates = 35;           ///< rad/s: in no motion is one row in a hundred faster
inline constexpr double kGravityTolerance = 1.35;  ///< allowed factor to the magnitude of gravity, in motion too

}  // namespace piste
