#include "condition/boresight.h"

#include <Eigen/Dense>
#include <cmath>
#include <limits>

namespace piste {
namespace {

// Least of the information about an angle, against the largest: below it is rounding.
constexpr double kRounding = 1e-12;
// Noise of r against noise of b makes an information of its own where nothing turns, of some √count · variance; by
// chance it exceeds four times that once in a million.
constexpr double kChance = 4;

}  // namespace

BoresightFromRates boresight_from_rates(std::span<const Vector3d> rate_r, std::span<const Vector3d> rate_b) {
  const auto count = static_cast<double>(rate_r.size());
  Vector3d mean_r = Vector3d::Zero(), mean_b = Vector3d::Zero();
  for (const Vector3d& w : rate_r) mean_r += w / count;
  for (const Vector3d& w : rate_b) mean_b += w / count;
  Matrix3d B = Matrix3d::Zero();
  for (std::size_t i = 0; i < rate_r.size(); ++i) B += (rate_r[i] - mean_r) * (rate_b[i] - mean_b).transpose();
  const Eigen::JacobiSVD<Matrix3d> svd(B, Eigen::ComputeFullU | Eigen::ComputeFullV);
  const double handed = svd.matrixU().determinant() * svd.matrixV().determinant() > 0 ? 1 : -1;
  const Matrix3d R_rb = svd.matrixU() * Vector3d(1, 1, handed).asDiagonal() * svd.matrixV().transpose();

  BoresightFromRates result;
  result.q_rb = Quaterniond(R_rb).normalized();
  result.gyro_bias = mean_b - R_rb.transpose() * mean_r;
  double squares = 0;
  for (std::size_t i = 0; i < rate_r.size(); ++i) {
    squares += (rate_b[i] - mean_b - R_rb.transpose() * (rate_r[i] - mean_r)).squaredNorm();
  }
  const double variance = squares / (3 * count - 6);
  result.residual = std::sqrt(squares / (3 * count));

  const Vector3d& s = svd.singularValues();
  result.residual_mirrored = handed > 0 ? result.residual : std::sqrt(std::max(0.0, squares - 4 * s.z()) / (3 * count));
  const Vector3d information(s.y() + handed * s.z(), s.x() + handed * s.z(), s.x() + s.y());
  if (information.x() <= std::max(kRounding * information.z(), kChance * std::sqrt(count) * variance)) {
    result.covariance.diagonal().setConstant(std::numeric_limits<double>::infinity());
  } else {
    result.covariance = variance * svd.matrixU() * information.cwiseInverse().asDiagonal() * svd.matrixU().transpose();
  }
  return result;
}

}  // namespace piste
