#pragma once
/// The one definition of the error of an estimate.
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

#include "piste/core/state_table.h"

namespace piste {

/// Value of a block that is no rotation, for reading and writing.
Eigen::Map<Eigen::VectorXd> additive(Estimate& x, Block block);
Eigen::Map<const Eigen::VectorXd> additive(const Estimate& x, Block block);
/// Value of a block that is a rotation.
Quaterniond& rotation(Estimate& x, Block block);
const Quaterniond& rotation(const Estimate& x, Block block);

/// Value of any block as files and plots show it but for the unit: a rotation as its Euler angles (roll, pitch,
/// heading), a block of one value with zeros after it.
Vector3d shown_value(const Estimate& x, Block block);

/// estimate ⊞ error for every block.
Estimate boxplus(const Estimate& x, const FullError& error);

/// estimate ⊞ error for the blocks of a layout; the other errors are zero. No heap.
Estimate boxplus(const Estimate& x, const StateLayout& layout, const ErrorVector& error);

/// The error with truth = estimate ⊞ error, attitude and boresight differences below π.
FullError boxminus(const Estimate& truth, const Estimate& estimate);

/// Covariance reset: an error e about `x` becomes G e about x ⊞ `correction`, to first order in e and to all
/// orders in the correction. G is the left Jacobian of the group: identity but for the 6×6 of (velocity, attitude)
/// and the 3×3 of every other rotation, such as the boresight. Rows and columns of `velocity_attitude`: ν, θ.
struct ResetJacobian {
  Eigen::Matrix<double, 6, 6> velocity_attitude;
  std::array<Matrix3d, kMountings> mountings;  ///< in the order of kMountingBlocks
};
ResetJacobian reset_jacobian(const FullError& correction);

/// Transform of the navigation error (ρ, ν, θ) into the ordinary one (δp, δv, θ) with δv = ν + θ × v̂.
Eigen::Matrix<double, 9, 9> ordinary_from_invariant(const Estimate& x);

/// Expands an error of the layout's blocks to every block, zero elsewhere.
FullError expand(const StateLayout& layout, const ErrorVector& error);

}  // namespace piste
