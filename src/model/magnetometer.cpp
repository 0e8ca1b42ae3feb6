#include "piste/model/magnetometer.h"

#include <cmath>
#include <numbers>

namespace piste {

double magnetic_azimuth(const Quaterniond& q_nb, const Vector3d& field_b) {
  const Vector3d m = q_nb * field_b;
  return std::atan2(m.y(), m.x());
}

Linearization linearize_magnetic_heading(const Vector3d& field_b, double declination, double sigma, const Estimate& x,
                                         const Matrix3d& R_wn) {
  const Vector3d m = R_wn.transpose() * (x.q_wb * field_b);
  Linearization lin;
  lin.observes = Block::kAttitude;
  lin.rows = 1;
  lin.residual.x() = std::remainder(declination - std::atan2(m.y(), m.x()), 2 * std::numbers::pi);
  lin.covariance(0, 0) = sigma * sigma;
  // m turns by θ × m = −[m] θ, with θ along n; d azimuth = (−m_e, m_n, 0) dm / |m_horizontal|².
  Matrix3d J = Matrix3d::Zero();
  J.row(0) = -Vector3d(-m.y(), m.x(), 0).transpose() * skew(m) / m.head<2>().squaredNorm();
  lin.add(Block::kAttitude, J * R_wn.transpose());
  return lin;
}

}  // namespace piste
