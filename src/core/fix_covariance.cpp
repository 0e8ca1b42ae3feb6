#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <utility>

#include "piste/core/log.h"

namespace piste {

Correlation correlations(const Matrix3d& covariance) {
  constexpr double kLeast = 0.01;  // least eigenvalue of a correlation matrix, so that its inverse is bounded
  const Vector3d variance = covariance.diagonal();
  if (!covariance.allFinite() || !(variance.minCoeff() > 0)) return Correlation::Zero();
  const Vector3d inverse = variance.cwiseSqrt().cwiseInverse();
  Matrix3d off = inverse.asDiagonal() * covariance * inverse.asDiagonal();
  off.diagonal().setZero();
  const double least = Eigen::SelfAdjointEigenSolver<Matrix3d>(off, Eigen::EigenvaluesOnly).eigenvalues().x();
  const double part = least < kLeast - 1 ? (kLeast - 1) / least : 1;
  return part * Correlation(off(1, 0), off(2, 0), off(2, 1));
}

Vector3d SlowLevel::next(double time, const Vector3d& sigma) {
  constexpr double kMinute = 60;  // s: half of τ
  const Vector3d stated = sigma.array().log();
  if (!begun_) {
    level_ = trend_ = stated;
    begun_ = true;
  }
  const double dt = std::max(0.0, time - time_), part = 1 - std::exp(-dt / kMinute);
  const Vector3d last = level_;
  for (int axis = 0; axis < 3; ++axis) {
    double& level = level_(axis);
    const double off = stated(axis) - level;
    const bool leaps = std::abs(off) > 1;  // of so large a change the state is a new one anyway
    level += leaps ? off : 0.5 * std::log1p(part * std::expm1(2 * off));
    if (leaps) trend_(axis) = level;
  }
  const Vector3d off = level_ - trend_;
  change_ += (level_ - last).cwiseAbs2() + dt / kMinute * off.cwiseAbs2();
  trend_ += part * off;
  time_ = time;
  return (level_ - stated).array().exp();
}

Vector3d SlowLevel::take_change() {
  constexpr double kPiece = 1e-3;
  if (change_.maxCoeff() < kPiece) return Vector3d::Zero();
  return std::exchange(change_, Vector3d::Zero());
}

Matrix3d GnssFix::position_factor() const {
  Matrix3d L = sigma_position.asDiagonal();
  if (correlation.isZero(0)) return L;
  const double ne = correlation.x(), nd = correlation.y(), ed = correlation.z();
  const double e = std::sqrt(1 - ne * ne), d_by_e = (ed - ne * nd) / e;
  L.row(1) = sigma_position.y() * Vector3d(ne, e, 0);
  L.row(2) = sigma_position.z() * Vector3d(nd, d_by_e, std::sqrt(1 - nd * nd - d_by_e * d_by_e));
  return L;
}

}  // namespace piste
