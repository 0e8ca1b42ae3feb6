#pragma once
/// Decides from an IMU and a receiver whether a body moves as a car does.
///
/// A car stays level while it accelerates and turns: its IMU measures both accelerations of the track. Skiers, cyclists
/// and aircraft lean into a turn: their IMU measures no lateral force. With means over 2 s above 5 m/s
///
///     f_b = forward · a_along + right · a_across + up
///
/// is fitted by least squares. In a car `forward` and `right` have the length 1 and are perpendicular, and the body
/// turns about `up` as the track does.

#include <string>

#include "piste/inspect/log_match.h"

namespace piste {

/// What distinguishes a car from other bodies. Without enough fast motion only `driving` is filled.
struct VehicleGuess {
  double driving = 0;                        ///< s faster than 5 m/s
  double turned_left = 0, turned_right = 0;  ///< sums of the turns while driving [rad]
  double force_along = 0, force_across = 0;  ///< fractions of the track's accelerations that the IMU measures
  double handed = 0;  ///< triple product of the fitted axes forward, right and down: 1 for a body frame
  double unlike = 0;  ///< rms of force across minus acceleration across, relative to the latter
  double slip = 0;    ///< median difference between the turns of body and track over 2 s [rad]

  /// Whether all of these numbers fit a car.
  bool is_car() const;
  /// Why the body is a car, in words.
  std::string why() const;
};

/// @pre `match` is that of these logs
VehicleGuess guess_vehicle(const ImuRecording& imu, const GnssRecording& gnss, const GnssHealth& health,
                           const LogMatch& match);

}  // namespace piste
