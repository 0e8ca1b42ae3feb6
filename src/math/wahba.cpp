#include "math/wahba.h"

#include <Eigen/LU>
#include <Eigen/SVD>

namespace piste {

WahbaSolution solve_wahba(const Matrix3d& B, bool mirrored) {
  const Eigen::JacobiSVD<Matrix3d> svd(B, Eigen::ComputeFullU | Eigen::ComputeFullV);
  const bool same_handed = svd.matrixU().determinant() * svd.matrixV().determinant() > 0;
  const Vector3d D(1, 1, same_handed != mirrored ? 1 : -1);
  return {svd.matrixU() * D.asDiagonal() * svd.matrixV().transpose(), svd.matrixU(),
          D.cwiseProduct(svd.singularValues())};
}

}  // namespace piste
