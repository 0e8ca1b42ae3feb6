#pragma once
/// Wahba's problem: the rotation that best turns one set of vectors into another.
///
/// Source: Markley 1988, Attitude determination using vector observations and the singular value decomposition,
/// Journal of the Astronautical Sciences 36.

#include "piste/math/so3.h"

namespace piste {

/// The solution R, and parts of the singular value decomposition from which it is computed: R = axes D Vᵀ with D =
/// diag(1, 1, ±1).
struct WahbaSolution {
  Matrix3d R = Matrix3d::Identity();
  Matrix3d axes = Matrix3d::Identity();  ///< columns: the principal axes, in the frame of b
  Vector3d gain = Vector3d::Zero();      ///< singular values of B times D; the third is negative if that of D is

  /// tr(Rᵀ B) = Σ w bᵀ R a. No other rotation has a larger one.
  double alignment() const { return gain.sum(); }
  /// Information about a small rotation about each of `axes`: the eigenvalues of tr(S) I − S, S = B Rᵀ.
  Vector3d information() const { return {gain.y() + gain.z(), gain.x() + gain.z(), gain.x() + gain.y()}; }
};

/// The rotation R that minimises Σ w |b − R a|², from B = Σ w b aᵀ. With `mirrored`, R is a rotation with a reflection
/// (det R = −1).
WahbaSolution solve_wahba(const Matrix3d& B, bool mirrored = false);

}  // namespace piste
