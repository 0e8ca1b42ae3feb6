#pragma once
/// The error model of an IMU, with the numbers that a data sheet or an Allan deviation gives. SI and radians.
///
///     measured = (1 + S + M) true + bias + drift + noise [+ G f],    S = diag(scale)
///
/// M has the cross-axis errors, which are its off-diagonal elements, and G is the gyroscopes' response to specific
/// force (model/imu_error_model.h).

#include <optional>
#include <string>

#include "piste/math/so3.h"

namespace piste {

/// How a bias changes in a run: not at all, as a random walk, or as a first-order Gauss-Markov process.
struct DriftProcess {
  enum class Kind { kNone, kRandomWalk, kGaussMarkov };
  Kind kind = Kind::kNone;
  double sigma = 0;             ///< Gauss-Markov: stationary standard deviation
  double correlation_time = 0;  ///< Gauss-Markov [s]
  double density = 0;           ///< random walk: unit/s/sqrt(Hz)
};

/// Errors of three axes of the same kind. One number holds for all three; the noise may differ between them.
struct TriadErrors {
  double noise = 0;    ///< density of the white noise: unit/sqrt(Hz); of axes that differ, their root mean square
  double bias = 0;     ///< 1-sigma of the turn-on bias
  DriftProcess drift;  ///< of the bias, in the run
  double scale = 0;    ///< 1-sigma, as a ratio
  /// 1-sigma of each element of M, as a ratio. Nothing: the file does not say, and 0 is taken.
  std::optional<double> cross_axis = std::nullopt;
  double range = 0;                  ///< a sample at ± range is clipped; 0 = unlimited
  Vector3d axes = Vector3d::Ones();  ///< noise of each axis, as a part of `noise`

  Vector3d densities() const { return noise * axes; }  ///< of the white noise of each axis
  Vector3d noise_variance() const { return densities().cwiseAbs2(); }
  void set_densities(const Vector3d& densities);  ///< sets `noise` and `axes`
};

struct ImuSensor {
  std::string name;
  TriadErrors gyro, accel;
  std::optional<double> gyro_g_sensitivity = std::nullopt;  ///< 1-sigma of each element of G [rad/s per m/s²]; likewise
};

/// The sensor model along other axes: R turns a vector of the sensor's axes into them. White noise of axes that differ
/// is taken to be independent after the turn too.
ImuSensor turned(ImuSensor sensor, const Matrix3d& R);

}  // namespace piste
