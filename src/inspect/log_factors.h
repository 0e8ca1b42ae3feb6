#pragma once
/// By how much an IMU's values are off by their units, beside a receiver's track.

#include "piste/inspect/log_match.h"

namespace piste {

/// Factors by which gyroscopes and accelerometers are to be multiplied.
struct LogFactors {
  double gyro = 1, accel = 1;
};

/// As the windows of the motion determine them; else from the turns of the track and the magnitude of gravity, if these
/// are clear.
LogFactors log_factors(const LogMatch& m);

/// Whether a factor is the expected one, as closely as a track tells it.
bool near_factor(double factor, double expected);

}  // namespace piste
