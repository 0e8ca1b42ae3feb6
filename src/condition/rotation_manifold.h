#pragma once
/// Unit quaternions as Ceres' manifold, with the boxplus of the whole project: q ⊞ φ = Exp(φ) q.

#include <ceres/manifold.h>

#include "piste/math/so3.h"

namespace piste {

/// Ambient space: Eigen's coefficients x, y, z, w. Tangent space: the rotation vector on the left [rad], while Ceres'
/// own manifold has half of it.
class RotationManifold final : public ceres::Manifold {
 public:
  using RowJacobian43 = Eigen::Matrix<double, 4, 3, Eigen::RowMajor>;
  using RowJacobian34 = Eigen::Matrix<double, 3, 4, Eigen::RowMajor>;

  int AmbientSize() const override { return 4; }
  int TangentSize() const override { return 3; }

  bool Plus(const double* x, const double* delta, double* x_plus_delta) const override {
    Eigen::Map<Quaterniond>{x_plus_delta} =
        (so3_exp(Eigen::Map<const Vector3d>(delta)) * Eigen::Map<const Quaterniond>(x)).normalized();
    return true;
  }

  bool PlusJacobian(const double* x, double* jacobian) const override {
    Eigen::Map<RowJacobian43>{jacobian} = plus_jacobian(Eigen::Map<const Quaterniond>(x));
    return true;
  }

  bool Minus(const double* y, const double* x, double* y_minus_x) const override {
    Eigen::Map<Vector3d>{y_minus_x} =
        so3_log(Eigen::Map<const Quaterniond>(y) * Eigen::Map<const Quaterniond>(x).conjugate());
    return true;
  }

  bool MinusJacobian(const double* x, double* jacobian) const override {
    Eigen::Map<RowJacobian34>{jacobian} = minus_jacobian(Eigen::Map<const Quaterniond>(x));
    return true;
  }

  /// d(Exp(φ) q) / dφ at φ = 0.
  static RowJacobian43 plus_jacobian(const Quaterniond& q) {
    RowJacobian43 J;
    J.topRows<3>() = 0.5 * (q.w() * Matrix3d::Identity() - skew(q.vec()));
    J.row(3) = -0.5 * q.vec().transpose();
    return J;
  }
  /// d Log(y q⁻¹) / dy at y = q: turns a derivative by φ into one by the coefficients.
  static RowJacobian34 minus_jacobian(const Quaterniond& q) { return 4 * plus_jacobian(q).transpose(); }
};

}  // namespace piste
