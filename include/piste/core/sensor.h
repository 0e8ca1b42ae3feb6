#pragma once
/// The error model of an IMU, with the numbers that a data sheet or an Allan deviation gives. SI and radians.
///
///     measured = (1 + scale) · true + bias + drift + noise, per axis

#include <Eigen/Core>
#include <string>

namespace piste {

/// How a bias changes in a run: not at all, as a random walk, or as a first-order Gauss-Markov process.
struct DriftProcess {
  enum class Kind { kNone, kRandomWalk, kGaussMarkov };
  Kind kind = Kind::kNone;
  double sigma = 0;             ///< Gauss-Markov: stationary standard deviation
  double correlation_time = 0;  ///< Gauss-Markov [s]
  double density = 0;           ///< random walk: unit/s/sqrt(Hz)
};

/// Errors of three axes of the same kind. One number holds for all three; the white noise may differ between them.
struct TriadErrors {
  double noise = 0;    ///< density of the white noise: unit/sqrt(Hz); of axes that differ, the root of their mean square
  double bias = 0;     ///< 1-sigma of the turn-on bias
  DriftProcess drift;  ///< of the bias, in the run
  double scale = 0;    ///< 1-sigma, as a ratio
  double range = 0;    ///< a sample at ± range is clipped; 0 = unlimited
  /// Densities of axes that differ, of which only the ratios count; zero: all axes have `noise`.
  Eigen::Vector3d axis_noise = Eigen::Vector3d::Zero();

  bool axes_differ() const { return !axis_noise.isZero(0); }
  /// Density of the white noise of each axis.
  Eigen::Vector3d densities() const;
  /// Sets `noise` and `axis_noise`.
  void set_densities(const Eigen::Vector3d& densities);
};

struct ImuSensor {
  std::string name;
  TriadErrors gyro, accel;
};

/// The sensor along other axes, R turning components along the old ones into the new: variances of the white noise turn
/// as the components do. The same where no axes differ.
ImuSensor turned(ImuSensor sensor, const Eigen::Matrix3d& R);

}  // namespace piste
