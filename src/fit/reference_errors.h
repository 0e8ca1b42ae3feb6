#pragma once
/// What is wrong with the reference signal itself: no length of the log makes it smaller.
///
/// To first order the true signal is the reference's + D p, with p of zero mean and covariance P: the clock's offset
/// and drift, boresight and lever arm (as the alignment found them, with all their correlations), and bias and scale of
/// the reference IMU (its sensor file). What the alignment did not determine was not applied, and is not in P either.

#include <Eigen/Core>
#include <cstddef>

#include "piste/condition/alignment.h"
#include "piste/core/aligned.h"
#include "piste/core/sensor.h"

namespace piste {

class ReferenceErrors {
 public:
  static constexpr int kSize = 10;  ///< offset, drift, boresight (3), lever arm (3), bias, scale
  using Row = Eigen::Matrix<double, 1, kSize>;
  using Covariance = Eigen::Matrix<double, kSize, kSize>;

  /// Refers to the signals, which must outlive it. Either pointer may be null: then the reference IMU, or the
  /// alignment, is taken as free of errors.
  ReferenceErrors(const AlignedImus& imus, const Alignment* alignment, const ImuSensor* reference);

  /// A row of D: sample i of specific force (axes 0 to 2) or angular rate (3 to 5).
  Row row(std::size_t i, int axis) const;
  /// P of that axis.
  Covariance covariance(int axis) const;

 private:
  Vector3d rate_of_change(const std::vector<Vector3d>& signal, std::size_t i) const;

  const AlignedImus& imus_;
  Matrix3d R_br_ = Matrix3d::Identity();
  Covariance P_force_ = Covariance::Zero(), P_rate_ = Covariance::Zero();
};

}  // namespace piste
