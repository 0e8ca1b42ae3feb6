#pragma once
/// Rotations: exponential, logarithm, their Jacobians, and Euler angles.
///
/// `R = Exp(phi)` with the rotation vector phi [rad]. Left Jacobian: Exp(phi + d) = Exp(J_l(phi) d) Exp(phi).
/// Euler angles are roll, pitch, heading of the sequence z-y-x: R_nb = R_z(heading) R_y(pitch) R_x(roll).
/// Source: Barfoot, State Estimation for Robotics, section 7.1; Groves, section 2.2.

#include <Eigen/Core>
#include <Eigen/Geometry>

namespace piste {

using Eigen::Matrix3d;
using Eigen::Quaterniond;
using Eigen::Vector3d;

/// Cross-product matrix: skew(a) b = a × b.
inline Matrix3d skew(const Vector3d& a) {
  Matrix3d m;
  m << 0, -a.z(), a.y(), a.z(), 0, -a.x(), -a.y(), a.x(), 0;
  return m;
}

/// Unit quaternion of the rotation vector, exact to rounding for any angle including 0.
Quaterniond so3_exp(const Vector3d& rotation_vector);

/// Rotation vector of norm at most π, exact to rounding near 0 and near π; `q` has norm 1, either sign.
Vector3d so3_log(const Quaterniond& q);

/// The shortest rotation q that turns the direction of a into that of b, q a ∥ b; where they are opposite, about one of
/// the axes across them. @pre neither is zero.
Quaterniond rotation_between(const Vector3d& a, const Vector3d& b);

/// J_l(phi) = Σ [phi]^n / (n+1)!; the right Jacobian is J_l(−phi).
Matrix3d so3_left_jacobian(const Vector3d& rotation_vector);

/// Q of the left Jacobian (J_l Q; 0 J_l) of the motion (nu, phi) in SE(3): the sum of the terms of Σ [phi]^n / (n+1)!
/// in which [nu] replaces one factor [phi]. Source: Barfoot, equation 7.86.
Matrix3d se3_left_jacobian_shift(const Vector3d& nu, const Vector3d& rotation_vector);

/// Inverse of the left Jacobian, for |phi| < 2π.
Matrix3d so3_left_jacobian_inverse(const Vector3d& rotation_vector);

/// Rotation from the angles (roll, pitch, heading) [rad].
Quaterniond from_euler(const Vector3d& roll_pitch_heading);

/// (roll, pitch, heading) [rad]: roll and heading in (−π, π], pitch in [−π/2, π/2]. At |pitch| = π/2
/// only roll ∓ heading is defined; roll is then 0.
Vector3d to_euler(const Quaterniond& q);
Vector3d to_euler(const Matrix3d& R);

/// E of d(rotation vector in the outer frame) = E d(roll, pitch, heading): columns are the three axes about
/// which the angles turn. Regular everywhere; singular at |pitch| = π/2.
Matrix3d euler_axes(const Vector3d& roll_pitch_heading);

/// Standard deviations of (roll, pitch, heading) [rad] from the covariance of the rotation vector in the outer frame.
/// Near |pitch| = π/2 they would grow without bound; they are limited to π.
Vector3d euler_sigma(const Quaterniond& q, const Matrix3d& covariance);
/// The same of the rotation R, where the covariance is along other axes: `turn` turns components along them into those
/// along the outer frame of R.
Vector3d euler_sigma(const Matrix3d& R, const Matrix3d& turn, const Matrix3d& covariance);

}  // namespace piste
