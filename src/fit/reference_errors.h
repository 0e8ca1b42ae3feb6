#pragma once
/// Errors of the reference signal itself. They do not become smaller in a longer log.
///
/// To first order the true signal is the reference's plus D p, where p has zero mean and the covariance P. It consists
/// of the clock's offset and drift, boresight and lever arm (from the alignment, with all correlations), and of bias
/// and scale of the reference IMU (from its sensor file). Parameters that the alignment did not determine were not
/// applied, and are not part of P.

#include <Eigen/Core>
#include <cstddef>

#include "piste/condition/alignment.h"
#include "piste/core/aligned.h"
#include "piste/core/sensor.h"

namespace piste {

/// The matrices D and P.
class ReferenceErrors {
 public:
  static constexpr int kSize = 10;  ///< offset, drift, boresight (3), lever arm (3), bias, scale
  using Row = Eigen::Matrix<double, 1, kSize>;
  using Covariance = Eigen::Matrix<double, kSize, kSize>;

  /// `imus` must outlive this object. Either pointer may be null: then the alignment, or the reference IMU, is taken to
  /// have no errors.
  ReferenceErrors(const AlignedImus& imus, const Alignment* alignment, const ImuSensor* reference);

  /// The row of D for sample i of a specific force (axes 0 to 2) or of an angular rate (3 to 5).
  Row row(std::size_t i, int axis) const;
  /// P for that axis.
  Covariance covariance(int axis) const;

 private:
  Vector3d rate_of_change(const std::vector<Vector3d>& signal, std::size_t i) const;

  const AlignedImus& imus_;
  Matrix3d R_br_ = Matrix3d::Identity();
  Covariance P_force_ = Covariance::Zero(), P_rate_ = Covariance::Zero();
};

}  // namespace piste
