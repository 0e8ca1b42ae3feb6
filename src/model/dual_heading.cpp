#include "piste/model/dual_heading.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace piste {

std::optional<Linearization> linearize_heading(const HeadingFix& fix, const Vector3d& baseline, const Estimate& x,
                                               const Matrix3d& R_wn) {
  constexpr double kUpright = 0.17;  // sine of 10 deg
  const Vector3d u = R_wn.transpose() * (x.q_wb * baseline.normalized());
  const double level = u.head<2>().norm();
  if (level < kUpright) return std::nullopt;
  Linearization lin;
  lin.observes = Block::kAttitude;
  lin.rows = 1;
  lin.residual.x() = std::remainder(fix.heading - std::atan2(u.y(), u.x()), 2 * std::numbers::pi);
  lin.covariance(0, 0) = fix.sigma * fix.sigma;
  // u turns by θ × u = −[u] θ, with θ along n; the azimuth changes by (−u_e, u_n, 0) du / level², the pitch by −du_d /
  // level.
  Matrix3d by_u = Matrix3d::Zero();
  by_u.row(0) = Vector3d(-u.y(), u.x(), 0).transpose() / (level * level);
  if (fix.pitch) {
    lin.rows = 2;
    lin.residual.y() = *fix.pitch - std::asin(std::clamp(-u.z(), -1.0, 1.0));
    lin.covariance(1, 1) = fix.sigma_pitch * fix.sigma_pitch;
    by_u(1, 2) = -1 / level;
  }
  lin.add(Block::kAttitude, -by_u * skew(u) * R_wn.transpose());
  return lin;
}

}  // namespace piste
