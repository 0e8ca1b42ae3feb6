#pragma once
/// The one definition of the error of an estimate.
///
/// truth = estimate ⊞ error, with error = (position ρ, velocity ν, attitude θ, …):
///
///     R_wb = Exp(θ) R̂_wb      v_wb = Exp(θ) v̂_wb + J_l(θ) ν      p_wb = p̂_wb + ρ
///     R_rb = Exp(β) R̂_rb      every other block: value + error
///
/// Attitude and velocity are one element of SE(3) with the error on the left (right-invariant, Barrau and Bonnabel
/// 2017). The transition of this error does not contain the noisy specific force. Position is additive, and not a third
/// column of SE₂(3): so a fix is linear in ρ wherever the origin of the run lies. The term [p]θ of the invariant error
/// would reach metres at some kilometres from the origin.

#include <optional>

#include "piste/core/state_table.h"

namespace piste {

/// Value of a block that is not a rotation, for reading and writing.
Eigen::Map<Eigen::VectorXd> additive(Estimate& x, Block block);
Eigen::Map<const Eigen::VectorXd> additive(const Estimate& x, Block block);
/// Value of a block that is a rotation.
Quaterniond& rotation(Estimate& x, Block block);
const Quaterniond& rotation(const Estimate& x, Block block);

/// Value of any block as files and plots show it, but in SI and radians. A rotation is given as its Euler angles (roll,
/// pitch, heading). Zeros follow the values of the block.
BlockValues shown_value(const Estimate& x, Block block);

/// estimate ⊞ error for every block.
Estimate boxplus(const Estimate& x, const FullError& error);

/// estimate ⊞ error for the blocks of a layout; the errors of the other blocks are zero. No heap.
Estimate boxplus(const Estimate& x, const StateLayout& layout, const ErrorVector& error);

/// The error for which truth = estimate ⊞ error. @pre attitudes and boresights differ by less than π.
FullError boxminus(const Estimate& truth, const Estimate& estimate);

/// The same for the blocks of a layout. No heap.
ErrorVector boxminus(const Estimate& truth, const Estimate& estimate, const StateLayout& layout);

/// The reset Jacobian G, for the covariance after a correction: an error e about the estimate x is G e about x ⊞
/// `correction`. This holds to first order in e and to all orders in the correction. G is the left Jacobian of the
/// group. It is the identity except for two parts: 6×6 of (velocity, attitude), in the order ν, θ, and 3×3 of every
/// other rotation, such as the boresight.
struct ResetJacobian {
  Eigen::Matrix<double, 6, 6> velocity_attitude;
  std::array<Matrix3d, kMountings> mountings;  ///< in the order of kMountingBlocks
  /// Derivatives of the position error after it by attitude and lever arm before it; only transport_jacobian() sets
  /// them.
  Matrix3d position_attitude = Matrix3d::Zero(), position_lever_arm = Matrix3d::Zero();
};
ResetJacobian reset_jacobian(const FullError& correction);

/// The same of a correction to the blocks of a layout. No heap.
ResetJacobian reset_jacobian(const StateLayout& layout, const ErrorVector& correction);

/// The estimate after a filter's correction. It is x ⊞ correction, except that velocity and antenna position take their
/// first-order corrections. Fixes observe these, however far the attitude turns; the position of the IMU follows.
/// `stands`: the body is stationary, and the velocity is that of x ⊞ correction.
Estimate corrected(const Estimate& x, const StateLayout& layout, const ErrorVector& correction, bool stands);

/// A body that stands, for the covariance transport.
struct Standing {
  Vector3d down;                 ///< a unit vector
  Eigen::Quaterniond last_q_wb;  ///< the attitude after the last correction at this rest, before it the present one
};

/// The reset Jacobian for the covariance transport of a filter over this correction of `x`. A filter knows combinations
/// of states for one attitude: position with the lever arm, or at rest tilt with the accelerometers' bias. If a
/// correction turned the attitude and left these combinations, the filter would take the correction for a turn of the
/// body. A real turn makes each state observable, a correction does not (Huang, Mourikis and Roumeliotis 2010, for
/// SLAM). Therefore the errors of the antenna's position, p + R l, and of the ordinary velocity stay, and that of the
/// attitude is reset. For a body that stands, ν stays instead, as its velocity is known to be zero. Its tilt then
/// turns with the heading, and an error of the heading stays one: otherwise standstill would seem to determine the
/// heading. What counts is the whole change since the last correction, as the body did not turn between them, but the
/// noise of the gyroscopes did turn its estimate. No heap.
ResetJacobian transport_jacobian(const Estimate& x, const StateLayout& layout, const ErrorVector& correction,
                                 const std::optional<Standing>& standing);

/// The matrix that turns the navigation error (ρ, ν, θ) into the ordinary error (δp, δv, θ), with δv = ν + θ × v̂.
Eigen::Matrix<double, 9, 9> ordinary_from_invariant(const Estimate& x);

/// The matrix that turns the navigation error (ρ, ν, θ) into the ordinary error (δp, δv, θ) along the local level,
/// where `R_wn` is that at the position (World::rotation_wn). Sigmas in files and pictures, and NEES, are of this
/// error.
Eigen::Matrix<double, 9, 9> level_from_invariant(const Matrix3d& R_wn, const Estimate& x);

/// The error of every block from the error of the layout's blocks; zero for the others.
FullError expand(const StateLayout& layout, const ErrorVector& error);

/// The error of the layout's blocks from that of every block.
ErrorVector select(const StateLayout& layout, const FullError& error);

}  // namespace piste
