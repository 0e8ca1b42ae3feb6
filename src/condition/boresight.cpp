#include "piste/condition/boresight.h"

#include <Eigen/Dense>
#include <limits>

namespace piste {

BoresightFromRates boresight_from_rates(std::span<const Vector3d> rate_r, std::span<const Vector3d> rate_b) {
  const auto count = static_cast<double>(rate_r.size());
  Vector3d mean_r = Vector3d::Zero(), mean_b = Vector3d::Zero();
  for (const Vector3d& w : rate_r) mean_r += w / count;
  for (const Vector3d& w : rate_b) mean_b += w / count;
  Matrix3d B = Matrix3d::Zero(), S = Matrix3d::Zero();
  double power_b = 0;
  for (std::size_t i = 0; i < rate_r.size(); ++i) {
    const Vector3d r = rate_r[i] - mean_r, b = rate_b[i] - mean_b;
    B += r * b.transpose();
    S += r * r.transpose();
    power_b += b.squaredNorm();
  }
  const Eigen::JacobiSVD<Matrix3d> svd(B, Eigen::ComputeFullU | Eigen::ComputeFullV);
  const double handed = svd.matrixU().determinant() * svd.matrixV().determinant();
  const Matrix3d R_rb = svd.matrixU() * Vector3d(1, 1, handed).asDiagonal() * svd.matrixV().transpose();

  BoresightFromRates result;
  result.q_rb = Quaterniond(R_rb).normalized();
  result.gyro_bias = mean_b - R_rb.transpose() * mean_r;
  const double squares = std::max(0.0, power_b + S.trace() - 2 * (R_rb.transpose() * B).trace());
  const double variance = squares / (3 * count - 6);
  result.residual = std::sqrt(squares / (3 * count));
  const Eigen::SelfAdjointEigenSolver<Matrix3d> information(S.trace() * Matrix3d::Identity() - S);
  // A turn about one axis alone leaves the angle about it free.
  constexpr double kRank = 1e-9;
  if (information.eigenvalues()(0) <= kRank * information.eigenvalues()(2)) {
    result.covariance.diagonal().setConstant(std::numeric_limits<double>::infinity());
  } else {
    result.covariance = variance * information.eigenvectors() * information.eigenvalues().cwiseInverse().asDiagonal() *
                        information.eigenvectors().transpose();
  }
  return result;
}

}  // namespace piste
