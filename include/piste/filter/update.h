#pragma once
/// The Kalman update by one measurement, also for a sensor that piste does not know (examples/own_sensor), and its
/// adjoint for the smoother.

#include "piste/model/measurement.h"

namespace piste {

/// All quantities of one update that filter and smoother need.
struct Update {
  Jacobian H;  ///< 3 × n; rows from Linearization::rows on are zero
  Eigen::Matrix<double, Eigen::Dynamic, 3, 0, kMostStates, 3> PHt;  ///< n × 3
  Matrix3d S, S_inverse;  ///< innovation covariance; unused rows are those of the identity
  Vector3d residual;
  Matrix3d R;  ///< noise covariance; unused rows likewise
  double nis = 0;
  int rows = 3;
  int observed = 0;  ///< first row of the block that the measurement mainly observes
};

/// Innovation of a linearised measurement: S = H P Hᵀ + R, nis = zᵀ S⁻¹ z. No heap.
Update innovate(const Covariance& P, const StateLayout& layout, const Linearization& lin);

/// Inverse of an innovation covariance. It is positive definite, or negative definite where an update removes
/// information (errors_in_variables.h).
Matrix3d inverse_of_definite(const Matrix3d& S);

/// Gain K = P Hᵀ S⁻¹.
Eigen::Matrix<double, Eigen::Dynamic, 3, 0, kMostStates, 3> gain(const Update& u);

/// P ← (I − K H) P. Where this removes nearly all of a variance, as after an outage, it is computed in the Joseph form,
/// which stays positive:
///
///     P ← (I − K H) P (I − K H)ᵀ + K R Kᵀ
///
/// Otherwise it is P − W Wᵀ with W = P Hᵀ L⁻ᵀ and S = L Lᵀ, which is several times faster and as accurate there. No
/// heap.
void update(Covariance& P, const Update& u);

/// P ← G P Gᵀ after a correction (estimate.h).
void reset(Covariance& P, const StateLayout& layout, const ResetJacobian& G);

/// e ← G e for an error.
void reset_error(ErrorVector& e, const StateLayout& layout, const ResetJacobian& G);

/// The adjoint of the reset: λ ← Gᵀ λ, Λ ← Gᵀ Λ G.
void reset_adjoint(ErrorVector& lambda, Covariance& Lambda, const StateLayout& layout, const ResetJacobian& G);
/// λ alone.
void reset_adjoint(ErrorVector& lambda, const StateLayout& layout, const ResetJacobian& G);

/// The adjoint of the update, from after it to before it: λ ← (I − K H)ᵀ λ − Hᵀ S⁻¹ z and Λ ← (I − K H)ᵀ Λ (I − K H) +
/// Hᵀ S⁻¹ H (Bryson and Frazier; Bierman 1977). If the measurement is far better than the prediction, as after an
/// outage, I − K H is computed without cancellation. P − P Λ P would otherwise lose all its digits.
void update_adjoint(ErrorVector& lambda, Covariance& Lambda, const Update& u);
/// λ alone.
void update_adjoint(ErrorVector& lambda, const Update& u);

/// The homogeneous part of both adjoints, for a matrix M with any number of columns: M ← Gᵀ M and M ← (I − K H)ᵀ M.
void reset_adjoint(Eigen::MatrixXd& columns, const StateLayout& layout, const ResetJacobian& G);
void update_adjoint(Eigen::MatrixXd& columns, const Update& u);

}  // namespace piste
