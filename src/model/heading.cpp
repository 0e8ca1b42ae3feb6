#include "piste/model/heading.h"

namespace piste {

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
