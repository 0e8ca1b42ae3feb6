#pragma once
/// Several IMUs on one body as one: the weights of their mean, the parities that are left of them, and what their
/// errors are in these terms.
///
/// Unit i measures y_i = (1 + s_i) u + b_i + d_i + n_i on every axis, with white noise of density σ_i, once it is
/// turned into the axes of the first and moved to its place. With weights w_i ∝ 1/σ_i², Σ w_i = 1,
///
///     û = Σ w_i y_i          p_k = Σ_i L_ki y_i,  Σ_i L_ki = 0,  k = 1 … N − 1
///
/// the noise of û and of all p_k is uncorrelated. So mechanizing û and measuring p equals a filter over the stacked y.
/// Errors of each kind (bias, drift, scale) are told apart likewise: e_i = c_i ē + Σ_k S_ik ε_k, where ē = Σ w_i e_i is
/// that of the mean IMU, which the blocks `gyro_bias` and so on estimate, and ε_k are the parity blocks of the state
/// table. c and S are such that ē and all ε_k are uncorrelated at first if the e_i are, for any sigmas. For units that
/// are alike c is 1, and S is L transposed.
/// Source: Waegli, Skaloud et al. 2008, Redundant MEMS-IMU integrated with GPS for performance assessment in sports
/// (PLANS), for synthetic and extended mechanization; the split of the states is our own.

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <span>
#include <vector>

#include "piste/core/sensor.h"
#include "piste/math/so3.h"

namespace piste {

/// Most IMUs that are taken as one, and most parities of them.
inline constexpr int kMostUnits = 4, kMostParities = kMostUnits - 1;

/// One value a unit.
using UnitVector = Eigen::Matrix<double, Eigen::Dynamic, 1, 0, kMostUnits, 1>;
/// A row a unit, a column a parity.
using UnitMatrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, kMostUnits, kMostParities>;

/// A triad of a sensor: its gyroscopes or its accelerometers.
using TriadMember = TriadErrors ImuSensor::*;

/// A kind of error of a triad.
enum class UnitError { kBias, kDrift, kScale };

/// The weights w of units whose white noise has these densities, all above zero.
UnitVector unit_weights(const UnitVector& noise);
UnitVector unit_weights(std::span<const ImuSensor> units, TriadMember triad);

/// The parities: the columns are the rows L_k above. Their noise is as dense as that of a unit whose variance is the
/// mean of the units' variances.
UnitMatrix parity_rows(const UnitVector& noise);
/// The density of the noise in each of them.
double parity_noise(const UnitVector& noise);

/// How errors of the units are made of that of their mean, ē, and those of the parity blocks.
struct UnitSplit {
  UnitVector common;  ///< c
  UnitMatrix split;   ///< S
};
/// The split of errors with these 1-sigmas by these weights. Those of the parity blocks have the 1-sigma
/// parity_sigma(). If no unit has an error, all is zero but c, which is 1.
UnitSplit split_errors(const UnitVector& weights, const UnitVector& sigma);
/// 1-sigma of the error of a parity block: the root mean square of the units' sigmas.
double parity_sigma(const UnitVector& sigma);

/// How the scales s of a unit add to its output. They act along its own axes, which R turns into those of the first:
/// there the output differs by R diag(s) Rᵀ u. They are in the order of the axes of the first that they lie nearest to.
class TurnedScale {
 public:
  explicit TurnedScale(const Matrix3d& R);
  /// Whether R turns every axis into one of the first, so that the scales act along these.
  bool at_right_angles() const;
  /// R diag(s) Rᵀ.
  Matrix3d effect(const Vector3d& s) const;
  /// The matrix that takes s to what it adds to the signal u: effect(s) u = by_scales(u) s.
  Matrix3d by_scales(const Vector3d& u) const;
  /// Values along the axes x, y and z of the unit, in the order of s.
  Vector3d ordered(const Vector3d& own) const { return own(order_); }

 private:
  std::array<int, 3> order_{0, 1, 2};
  Matrix3d R_;  ///< its columns in that order
};

/// Of each unit: the densities of the white noise of a triad; the 1-sigma of an error. Of a random walk that is its
/// density.
UnitVector unit_noise(std::span<const ImuSensor> units, TriadMember triad);
UnitVector unit_sigmas(std::span<const ImuSensor> units, TriadMember triad, UnitError error);

/// The sensor that the weighted mean of the units is: its noise, and 1-sigmas of its errors if those of the units are
/// independent. The range is the smallest. Of drifts with unlike correlation times, whose sum is no process of the
/// first order, it has their mean by variance. Throws ConfigError if one unit drifts as a random walk and another by
/// Gauss-Markov.
/// @pre There is a unit.
ImuSensor mean_sensor(std::span<const ImuSensor> units);

/// The drift of a parity block of a triad.
DriftProcess parity_drift(std::span<const ImuSensor> units, TriadMember triad);

}  // namespace piste
