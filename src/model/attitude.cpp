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

}  // namespace piste
