#include "condition/boresight.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "math/wahba.h"

namespace piste {
namespace {

// Smallest information about an angle relative to the largest. Below it, it is rounding error.
constexpr double kRounding = 1e-12;
// Where nothing turns, the noises of r and b together look like information, of some √count · variance. By chance it
// exceeds four times that once in a million.
constexpr double kChance = 4;

}  // namespace

BoresightFromRates boresight_from_rates(std::span<const Vector3d> rate_r, std::span<const Vector3d> rate_b) {
  const auto count = static_cast<double>(rate_r.size());
  Vector3d mean_r = Vector3d::Zero(), mean_b = Vector3d::Zero();
  for (const Vector3d& w : rate_r) mean_r += w / count;
  for (const Vector3d& w : rate_b) mean_b += w / count;
  Matrix3d B = Matrix3d::Zero();
  for (std::size_t i = 0; i < rate_r.size(); ++i) B += (rate_r[i] - mean_r) * (rate_b[i] - mean_b).transpose();
  const WahbaSolution wahba = solve_wahba(B);
  const Matrix3d& R_rb = wahba.R;

  BoresightFromRates result;
  result.q_rb = Quaterniond(R_rb).normalized();
  result.gyro_bias = mean_b - R_rb.transpose() * mean_r;
  double squares = 0;
  for (std::size_t i = 0; i < rate_r.size(); ++i) {
    squares += (rate_b[i] - mean_b - R_rb.transpose() * (rate_r[i] - mean_r)).squaredNorm();
  }
  const double variance = squares / (3 * count - 6);
  result.residual = std::sqrt(squares / (3 * count));
  // A rotation with a reflection would fit better by the loss of this one along the third axis.
  const double lost = 4 * std::max(0.0, -wahba.gain.z());
  result.residual_mirrored = std::sqrt(std::max(0.0, squares - lost) / (3 * count));
  const Vector3d information = wahba.information();
  if (information.x() <= std::max(kRounding * information.z(), kChance * std::sqrt(count) * variance)) {
    result.covariance.diagonal().setConstant(std::numeric_limits<double>::infinity());
  } else {
    result.covariance = variance * wahba.axes * information.cwiseInverse().asDiagonal() * wahba.axes.transpose();
  }
  return result;
}

}  // namespace piste
