#pragma once
/// Whether a body moves as a car does, by its IMU and a receiver.
///
/// A car stays level while it accelerates and turns: its IMU feels both accelerations of the track. Who leans into a
/// turn, as skiers, cyclists and aircraft do, feels no force across it. With means over 2 s above 5 m/s
///
///     f_b = forward · a_along + right · a_across + up
///
/// is fitted by least squares: in a car both vectors have the length 1, stand upright on each other, and the body
/// turns about `up` as the track does.

#include <string>

#include "piste/inspect/log_match.h"

namespace piste {

/// What tells a car from other bodies. Without enough fast motion only `driving` is filled.
struct VehicleGuess {
  double driving = 0;                        ///< s faster than 5 m/s
  double turned_left = 0, turned_right = 0;  ///< sums of the turns meanwhile [rad]
  double force_along = 0, force_across = 0;  ///< parts of the accelerations of the track that the body feels
  double handed = 0;  ///< triple product of the axes forward, right and down that were found: 1 for those of a body
  double unlike = 0;  ///< rms of the force across less the acceleration across, relative to that
  double slip = 0;    ///< median difference in turns of body and track over 2 s [rad]

  /// Whether all of them are those of a car.
  bool is_car() const;
  /// Why it is one, in words.
  std::string why() const;
};

/// @pre `match` is that of these logs
VehicleGuess guess_vehicle(const ImuRecording& imu, const GnssRecording& gnss, const GnssHealth& health,
                           const LogMatch& match);

}  // namespace piste
