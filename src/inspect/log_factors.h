#pragma once
/// The factors by which an IMU's units are wrong, from a receiver's track.

#include "piste/inspect/log_match.h"

namespace piste {

/// Factors by which gyroscopes and accelerometers are to be multiplied.
struct LogFactors {
  double gyro = 1, accel = 1;
};

/// From the windows of the motion if they determine the factors; else from the turns of the track and the magnitude of
/// gravity, if these are clear.
LogFactors log_factors(const LogMatch& m);

/// Whether a factor is the expected one, within the accuracy of a track.
bool near_factor(double factor, double expected);

/// The same, and nearer to it than to one: at a row a second, increments are as large as rates, and nothing is wrong.
bool rather_factor(double factor, double expected);

}  // namespace piste
