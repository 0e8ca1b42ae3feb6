#pragma once
/// Cuts the windows in which an IMU is compared with a track. In all of them the body moves.

#include <optional>
#include <vector>

#include "log_signals.h"

namespace piste {

inline constexpr double kCell = 0.04, kWindow = 5, kStride = 2.5;  ///< s
inline constexpr std::size_t kEvery = 6;                           ///< cells between two velocities of the track

/// One window: the IMU in cells, and the velocity of the track at the beginning and at every kEvery-th end of a cell.
struct MotionWindow {
  double begin = 0;  ///< of the track
  std::vector<ImuIntegral::Value> cells;
  std::vector<Vector3d> velocity;
  double change = 0;  ///< rms of the velocity about its mean [m/s]
};

/// The signals from which windows are cut.
struct MotionSource {
  const ImuIntegral& imu;
  const Track& track;
  Vector3d bias;  ///< of the gyroscopes, in their unit

  /// The window that begins at time `begin` of the track. The IMU's clock is `offset` ahead. Returns nullopt if one of
  /// the two does not cover the window, if the IMU clips, or if the velocity hardly changes.
  std::optional<MotionWindow> window(double begin, double offset) const;
  /// Windows spread over the time that both cover.
  std::vector<MotionWindow> windows(double offset) const;
};

/// The gyroscopes' bias: their mean at rest. Without rest it is their median, because most of a journey is without
/// turns.
Vector3d gyro_bias(const ImuIntegral& imu, const std::vector<Interval>& rest, double offset);

}  // namespace piste
