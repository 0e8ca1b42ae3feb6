#pragma once
/// The windows of a log in which an IMU and a track are compared, cut where the body moves.

#include <optional>
#include <vector>

#include "log_signals.h"

namespace piste {

inline constexpr double kCell = 0.04, kWindow = 5, kStride = 2.5;  ///< s
inline constexpr std::size_t kEvery = 6;                           ///< cells between looks at the track

/// One window: the IMU in cells, and the track at every kEvery-th of their ends, the first at the beginning.
struct MotionWindow {
  double begin = 0;  ///< of the track
  std::vector<ImuIntegral::Value> cells;
  std::vector<Vector3d> velocity;
  double change = 0;  ///< rms of the velocity about its mean [m/s]
};

/// What windows are cut from.
struct MotionSource {
  const ImuIntegral& imu;
  const Track& track;
  Vector3d bias;  ///< of the gyroscopes, in their unit

  /// The window that begins at `begin` of the track, the IMU's clock being `offset` ahead. nullopt where one of the two
  /// does not cover it, the IMU clips, or the velocity hardly changes.
  std::optional<MotionWindow> window(double begin, double offset) const;
  /// Windows spread over what both cover.
  std::vector<MotionWindow> windows(double offset) const;
};

/// The gyroscopes' mean at rest; without rest their median, as most of a journey does not turn.
Vector3d gyro_bias(const ImuIntegral& imu, const std::vector<Interval>& rest, double offset);

}  // namespace piste
