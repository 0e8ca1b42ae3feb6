#include "piste/model/attitude.h"

namespace piste {

namespace {

Quaterniond reference_of(const Estimate& x) {
  return so3_exp(x.attitude_drift) * x.q_wb * (so3_exp(x.boresight_drift) * x.q_rb).conjugate();
}

}  // namespace

Linearization linearize_attitude(const AttitudeFix& fix, const Vector3d& white, const Estimate& x,
                                 const Estimate* after) {
  const Quaterniond predicted = reference_of(x);
  Linearization lin;
  lin.observes = Block::kAttitude;
  lin.residual = so3_log(fix.q_wr * predicted.conjugate());
  const Matrix3d noise = so3_left_jacobian_inverse(lin.residual) * white.asDiagonal();
  lin.covariance = noise * fix.covariance * noise.transpose();

  Matrix3d J = so3_left_jacobian_inverse(-lin.residual), R_wr = J * predicted.toRotationMatrix();
  if (after != nullptr) {
    const Vector3d turn = so3_log(reference_of(*after) * predicted.conjugate());
    J.setIdentity();
    R_wr = (so3_exp(0.5 * turn) * predicted).toRotationMatrix();
  }
  lin.add(Block::kAttitude, J * so3_exp(x.attitude_drift).toRotationMatrix());
  lin.add(Block::kBoresight, -R_wr * so3_exp(x.boresight_drift).toRotationMatrix());
  lin.add(Block::kAttitudeDrift, J * so3_left_jacobian(x.attitude_drift));
  lin.add(Block::kBoresightDrift, -R_wr * so3_left_jacobian(x.boresight_drift));
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
