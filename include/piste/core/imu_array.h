#pragma once
/// Several IMUs on one body, fused to one: the weights of their mean, their parities, and their errors in these terms.
/// Turned into the axes of the first and moved to its place, IMU i measures y_i = (1 + s_i) u + b_i + d_i + n_i on
/// every axis, with white noise of density σ_i. With weights w_i ∝ 1/σ_i², Σ w_i = 1,
///
///     û = Σ w_i y_i          p_k = Σ_i L_ki y_i,  Σ_i L_ki = 0,  k = 1 … N − 1
///
/// the noise of û and of all p_k is uncorrelated. So mechanizing û and measuring p equals a filter over the stacked y.
/// Errors of each kind (bias, drift, scale) are split likewise: e_i = c_i ē + Σ_k S_ik ε_k. Here ē = Σ w_i e_i is the
/// error of the mean IMU, which the blocks `gyro_bias` and so on estimate, and ε_k are the parity blocks of the state
/// table. c and S are such that ē and all ε_k are initially uncorrelated if the e_i are, for any sigmas. For IMUs with
/// equal sigmas c is 1, and S is L transposed. Source: Waegli, Skaloud et al. 2008, Redundant MEMS-IMU integrated with
/// GPS for performance assessment in sports (PLANS), for synthetic and extended mechanization; the split of the states
/// is our own.

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <span>
#include <vector>

#include "piste/core/sensor.h"
#include "piste/math/so3.h"

namespace piste {

/// The largest number of fused IMUs, and of their parities.
inline constexpr int kMostImus = 4, kMostParities = kMostImus - 1;

/// One value per IMU.
using ImuVector = Eigen::Matrix<double, Eigen::Dynamic, 1, 0, kMostImus, 1>;
/// A row per IMU, a column per parity.
using ImuMatrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, kMostImus, kMostParities>;

/// A triad of a sensor: its gyroscopes or its accelerometers.
using TriadMember = TriadErrors ImuSensor::*;

/// A kind of error of a triad.
enum class ImuErrorKind { kBias, kDrift, kScale };

/// The weights w of IMUs whose white noise has these densities, all above zero: {0.8, 0.2} for densities 1 and 2.
ImuVector imu_weights(const ImuVector& noise);
ImuVector imu_weights(std::span<const ImuSensor> imus, TriadMember triad);

/// The parities: the columns are the rows L_k above. The noise variance of each is the mean of the IMUs' variances.
ImuMatrix parity_rows(const ImuVector& noise);
/// The density of the noise in each of them.
double parity_noise(const ImuVector& noise);

/// How the errors of the IMUs follow from that of their mean, ē, and from those of the parity blocks.
struct ErrorSplit {
  ImuVector common;  ///< c
  ImuMatrix split;   ///< S
};
/// The split of errors with these 1-sigmas by these weights. The errors of the parity blocks have the 1-sigma
/// parity_sigma(). If no IMU has an error, S is zero and c is 1.
ErrorSplit split_errors(const ImuVector& weights, const ImuVector& sigma);
/// 1-sigma of the error of a parity block: the root mean square of the IMUs' sigmas.
double parity_sigma(const ImuVector& sigma);

/// How the scales s of an IMU add to its output. They act along its own axes, which R turns into those of the first:
/// there the output differs by R diag(s) Rᵀ u. Each scale is stored at the axis of the first IMU that its axis is
/// nearest to.
class TurnedScale {
 public:
  explicit TurnedScale(const Matrix3d& R);
  /// Whether R turns every axis into one of the first, so that the scales act along these.
  bool at_right_angles() const;
  /// R diag(s) Rᵀ.
  Matrix3d effect(const Vector3d& s) const;
  /// The derivative of the output by s for a signal u: effect(s) u = by_scales(u) s.
  Matrix3d by_scales(const Vector3d& u) const;
  /// Values along the axes x, y and z of the IMU, in the order of s.
  Vector3d ordered(const Vector3d& own) const { return own(order_); }

 private:
  std::array<int, 3> order_{0, 1, 2};
  Matrix3d R_;  ///< its columns in that order
};

/// Of each IMU: the densities of the white noise of a triad; the 1-sigma of an error. For a random walk the latter is
/// its density.
ImuVector imu_noise(std::span<const ImuSensor> imus, TriadMember triad);
ImuVector imu_sigmas(std::span<const ImuSensor> imus, TriadMember triad, ImuErrorKind error);

/// The sensor model of the weighted mean of the IMUs: its noise, and 1-sigmas of its errors if those of the IMUs are
/// independent. The range is the smallest. The sum of drifts with different correlation times is no first-order
/// process: the model has their mean correlation time, weighted by variance. Throws ConfigError if one IMU drifts as a
/// random walk and another as Gauss-Markov.
/// @pre There is an IMU.
ImuSensor mean_sensor(std::span<const ImuSensor> imus);

/// The drift of a parity block of a triad.
DriftProcess parity_drift(std::span<const ImuSensor> imus, TriadMember triad);

}  // namespace piste
