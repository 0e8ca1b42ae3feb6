#include "piste/model/magnetometer.h"

#include <cmath>

namespace piste {

double azimuth(const Vector3d& field_n) { return std::atan2(field_n.y(), field_n.x()); }

Linearization linearize_magnetic_field(const MagneticSample& sample, double sigma, const Estimate& x,
                                       const Matrix3d& R_wn) {
  Matrix3d bent = Matrix3d::Identity();  // 1 + S
  bent.row(0) += x.soft_iron_x.transpose();
  bent.row(1) += x.soft_iron_y.transpose();
  bent.row(2) += x.soft_iron_z.transpose();
  const Matrix3d R_bw = x.R_wb().transpose();
  const Vector3d earth_w = R_wn * sample.earth, disturbance_w = R_wn * x.magnetic_disturbance;
  const Vector3d earth_b = R_bw * earth_w;
  Linearization lin;
  lin.observes = Block::kHardIron;
  lin.residual = sample.field - (bent * earth_b + R_bw * disturbance_w + x.hard_iron);
  lin.covariance = sigma * sigma * Matrix3d::Identity();
  // R_wb is Exp(θ) R̂: R_bw field turns by R_bw [field] θ.
  lin.add(Block::kAttitude, bent * R_bw * skew(earth_w) + R_bw * skew(disturbance_w));
  lin.add(Block::kHardIron, Matrix3d::Identity());
  constexpr std::array kRows{Block::kSoftIronX, Block::kSoftIronY, Block::kSoftIronZ};
  for (int i = 0; i < 3; ++i) lin.add(kRows[static_cast<std::size_t>(i)], Vector3d::Unit(i) * earth_b.transpose());
  lin.add(Block::kMagneticDisturbance, R_bw * R_wn);
  return lin;
}

}  // namespace piste
