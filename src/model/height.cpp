#include "piste/model/height.h"

namespace piste {

Linearization linearize_height(const HeightFix& fix, const Estimate& x, const Gravity& gravity) {
  const Vector3d down = gravity.R_wn.col(2);
  Linearization lin;
  lin.rows = 1;
  lin.residual.x() = fix.height - (gravity.height - down.dot(x.p_wb - gravity.point) + x.barometer_offset);
  lin.covariance(0, 0) = fix.sigma * fix.sigma;
  Matrix3d J = Matrix3d::Zero();
  J.row(0) = -down.transpose();
  lin.add(Block::kPosition, J);
  lin.add(Block::kBarometerOffset, Vector3d::UnitX() * Eigen::RowVector3d::UnitX());
  return lin;
}

}  // namespace piste
