#pragma once
/// What we believe at one instant, and the one definition of its error.
///
/// truth = estimate ⊞ error, with error = (position ρ, velocity ν, attitude θ, …):
///
///     R_wb = Exp(θ) R̂_wb      v_wb = Exp(θ) v̂_wb + J_l(θ) ν      p_wb = p̂_wb + ρ
///     R_rb = Exp(β) R̂_rb      every other block: value + error
///
/// Attitude and velocity are one element of SE(3) with the error on the left (right-invariant, Barrau and Bonnabel
/// 2017): its transition does not contain the noisy specific force. Position is additive and not a third column of
/// SE₂(3): a fix is then linear in ρ wherever the run's origin lies, while [p]θ of the invariant error reaches
/// metres at some kilometres.

#include "piste/core/state_layout.h"
#include "piste/math/so3.h"

namespace piste {

struct Estimate {
  Quaterniond q_wb = Quaterniond::Identity();
  Vector3d v_wb = Vector3d::Zero();
  Vector3d p_wb = Vector3d::Zero();
  Vector3d gyro_bias = Vector3d::Zero();
  Vector3d accel_bias = Vector3d::Zero();
  Vector3d gyro_drift = Vector3d::Zero();
  Vector3d accel_drift = Vector3d::Zero();
  Vector3d gyro_scale = Vector3d::Zero();
  Vector3d accel_scale = Vector3d::Zero();
  Quaterniond q_rb = Quaterniond::Identity();  ///< boresight: b components into r
  Vector3d lever_arm = Vector3d::Zero();       ///< p_ba_b
  Vector3d gnss_position_drift = Vector3d::Zero();
  double gnss_delay = 0;                        ///< a fix stamped t is of t − gnss_delay
  Vector3d attitude_drift = Vector3d::Zero();   ///< of the reference attitude, rotation vector in w
  Vector3d boresight_drift = Vector3d::Zero();  ///< a mount that gives: Exp(drift) R_rb, rotation vector in r

  Matrix3d R_wb() const { return q_wb.toRotationMatrix(); }
  Matrix3d R_rb() const { return q_rb.toRotationMatrix(); }
};

/// Value of an additive block (every block but attitude and boresight), for reading and writing. A scalar block
/// uses the first element of the returned map.
Eigen::Map<Eigen::VectorXd> additive(Estimate& x, Block block);
Eigen::Map<const Eigen::VectorXd> additive(const Estimate& x, Block block);

/// estimate ⊞ error for every block.
Estimate boxplus(const Estimate& x, const FullError& error);

/// estimate ⊞ error for the blocks of a layout; the other errors are zero. No heap.
Estimate boxplus(const Estimate& x, const StateLayout& layout, const ErrorVector& error);

/// The error with truth = estimate ⊞ error, attitude and boresight differences below π.
FullError boxminus(const Estimate& truth, const Estimate& estimate);

/// Covariance reset: an error e about `x` becomes G e about x ⊞ `correction`, to first order in e and to all
/// orders in the correction. G is the left Jacobian of the group: identity but for the 6×6 of (velocity, attitude)
/// and the 3×3 of boresight. Rows and columns of `velocity_attitude`: ν, θ.
struct ResetJacobian {
  Eigen::Matrix<double, 6, 6> velocity_attitude;
  Matrix3d boresight;
};
ResetJacobian reset_jacobian(const FullError& correction);

/// Transform of the navigation error (ρ, ν, θ) into the ordinary one (δp, δv, θ) with δv = ν + θ × v̂.
Eigen::Matrix<double, 9, 9> ordinary_from_invariant(const Estimate& x);

/// Expands an error of the layout's blocks to every block, zero elsewhere.
FullError expand(const StateLayout& layout, const ErrorVector& error);

}  // namespace piste
