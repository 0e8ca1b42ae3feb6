#pragma once
/// What a data sheet or an Allan deviation says of an IMU. SI and radians.
///
/// measured = (1 + scale) · true + bias + drift + noise, per axis.

#include <string>

namespace piste {

/// In-run drift of a bias: absent, random walk, or first-order Gauss-Markov.
struct DriftProcess {
  enum class Kind { kNone, kRandomWalk, kGaussMarkov };
  Kind kind = Kind::kNone;
  double sigma = 0;             ///< Gauss-Markov: stationary standard deviation
  double correlation_time = 0;  ///< Gauss-Markov [s]
  double density = 0;           ///< random walk: unit/s/sqrt(Hz)
};

/// Errors of three like axes.
struct TriadErrors {
  double noise = 0;    ///< density of the white noise: unit/sqrt(Hz)
  double bias = 0;     ///< 1-sigma of the turn-on constant
  DriftProcess drift;  ///< in-run
  double scale = 0;    ///< 1-sigma, as a ratio
  double range = 0;    ///< a sample at ± range is clipped; 0 = unlimited
};

struct ImuSensor {
  std::string name;
  TriadErrors gyro, accel;
};

}  // namespace piste
