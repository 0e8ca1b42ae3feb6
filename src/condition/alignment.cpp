#include "piste/condition/alignment.h"

#include <cmath>
#include <limits>
#include <numbers>

namespace piste {

Vector3d Alignment::boresight_sigma() const {
  Matrix3d of_rotation = covariance.block<3, 3>(AlignmentLayout::kBoresight, AlignmentLayout::kBoresight);
  for (int i = 0; i < 3; ++i) {
    if (!std::isfinite(of_rotation(i, i))) of_rotation(i, i) = std::numbers::pi * std::numbers::pi;
  }
  constexpr double kOpen = 0.1;  // rad
  Vector3d sigma = euler_sigma(q_rb, of_rotation);
  for (double& s : sigma) {
    if (s > kOpen) s = std::numeric_limits<double>::infinity();
  }
  return sigma;
}

}  // namespace piste
