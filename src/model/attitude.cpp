#include "piste/model/attitude.h"

namespace piste {

Linearization linearize_attitude(const AttitudeFix& fix, bool coloured, const Estimate& x) {
  const Quaterniond drift = so3_exp(x.attitude_drift);
  const Quaterniond predicted = drift * x.q_wb * x.q_rb.conjugate();
  Linearization lin;
  lin.observes = Block::kAttitude;
  lin.residual = so3_log(fix.q_wr * predicted.conjugate());
  const Matrix3d J = so3_left_jacobian_inverse(-lin.residual);
  const Matrix3d noise = so3_left_jacobian_inverse(lin.residual);
  lin.covariance = (coloured ? 0.01 : 1.0) * noise * fix.covariance * noise.transpose();
  lin.add(Block::kAttitude, J * drift.toRotationMatrix());
  lin.add(Block::kBoresight, -J * predicted.toRotationMatrix());
  lin.add(Block::kAttitudeDrift, J * so3_left_jacobian(x.attitude_drift));
  return lin;
}

Linearization linearize_heading(const HeadingFix& fix, const Estimate& x) {
  const Vector3d z = so3_log(fix.q_wb * x.q_wb.conjugate());
  Linearization lin;
  lin.observes = Block::kAttitude;
  lin.rows = 1;
  lin.residual.x() = z.z();
  lin.covariance(0, 0) = fix.sigma * fix.sigma;
  Matrix3d J = Matrix3d::Zero();
  J.row(0) = so3_left_jacobian_inverse(-z).row(2);
  lin.add(Block::kAttitude, J);
  return lin;
}

}  // namespace piste
