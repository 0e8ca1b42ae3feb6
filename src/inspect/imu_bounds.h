#pragma once
/// Bounds by which an IMU's log is measured and spoken of.

namespace piste {

inline constexpr double kFastRates = 35;           ///< rad/s: no body turns faster in one row of a hundred
inline constexpr double kGravityTolerance = 1.35;  ///< factor to the magnitude of gravity, in motion too

}  // namespace piste
