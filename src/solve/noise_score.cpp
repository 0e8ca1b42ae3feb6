#include "piste/solve/noise_score.h"

#include "math/wide.h"

namespace piste {
namespace {

constexpr Block kScales[] = {Block::kGyroScale, Block::kAccelScale};

// Eliminates the first `count` rows of a symmetric matrix, of which the lower half is there.
PISTE_WIDE void eliminate(double* C, std::ptrdiff_t size, std::ptrdiff_t count) {
  for (std::ptrdiff_t k = 0; k < count; ++k) {
    const double* __restrict pivot = C + k * size;
    if (!(pivot[k] > 0)) continue;  // known exactly
    const double inverse = 1 / pivot[k];
    for (std::ptrdiff_t j = k + 1; j < size; ++j) {
      double* __restrict column = C + j * size;
      const double factor = pivot[j] * inverse;
      for (std::ptrdiff_t i = j; i < size; ++i) column[i] -= factor * pivot[i];
    }
  }
}

}  // namespace

NoiseScore::NoiseScore(const FilterOptions& options, const StateLayout& layout) {
  const double gyro = options.sensor.gyro.noise, accel = options.sensor.accel.noise;
  if (layout.has(Block::kGyroScale) && options.attitude.empty()) gyro_ = gyro * gyro;
  if (layout.has(Block::kAccelScale)) accel_ = accel * accel;
}

// Covariances along the body's axes of attitude and velocity, for given errors of everything else: what a bias hides
// of the tilt is not what the noise turns. It is the ordinary velocity that fixes show.
NoiseScore::Known NoiseScore::known(const Estimate& x, const Covariance& P) {
  constexpr int kVelocity = full_offset(Block::kVelocity), kNavigation = 9, kFast = 6;
  const Eigen::Index others = P.rows() - kNavigation, size = others + kFast;
  // The slow states first; eliminating them leaves the covariance of velocity and attitude for given values of them
  // (Schur's complement). Only the lower half is there.
  Covariance C(size, size);
  C.topLeftCorner(others, others) = P.bottomRightCorner(others, others);
  C.bottomLeftCorner(kFast, others) = P.block(kVelocity, kNavigation, kFast, others);
  C.bottomRightCorner<kFast, kFast>() = P.block<kFast, kFast>(kVelocity, kVelocity);
  eliminate(C.data(), size, others);
  using Matrix6d = Eigen::Matrix<double, kFast, kFast>;
  const Matrix6d lower = C.bottomRightCorner<kFast, kFast>(), fast = lower.selfadjointView<Eigen::Lower>();
  const Matrix3d R = x.R_wb();
  const Eigen::Matrix<double, 3, kFast> velocity =
      R.transpose() * ordinary_from_invariant(x).block<3, kFast>(kVelocity, kVelocity);
  return {R.transpose() * fast.bottomRightCorner<3, 3>() * R, velocity * fast * velocity.transpose()};
}

void NoiseScore::before_fix(const Estimate& x, const Covariance& P) {
  if (!before_ && gyro_time_ > 0 && gyro_ + accel_ > 0) before_ = known(x, P);
}

std::optional<ScaleScore> NoiseScore::after_fixes(const Estimate& x, const Covariance& P) {
  if (!before_) return std::nullopt;
  const Known after = known(x, P);
  ScaleScore score;
  score << gyro_ * gyro_time_ * (before_->attitude + after.attitude).inverse().diagonal(),
      accel_ * accel_time_ * (before_->velocity + after.velocity).inverse().diagonal();
  before_.reset();
  gyro_time_ = accel_time_ = 0;
  return score;
}

ErrorVector pull_of(const ScaleScore& score, const StateLayout& layout, const Covariance& P) {
  ErrorVector pull = ErrorVector::Zero(layout.size());
  for (Eigen::Index k = 0; k < 2; ++k) {
    if (layout.has(kScales[k])) pull += P.middleCols<3>(layout.offset(kScales[k])) * score.segment<3>(3 * k);
  }
  return pull;
}

void add_score(ErrorVector& lambda, const StateLayout& layout, const ScaleScore& score) {
  for (Eigen::Index k = 0; k < 2; ++k) {
    if (layout.has(kScales[k])) lambda.segment<3>(layout.offset(kScales[k])) += score.segment<3>(3 * k);
  }
}

}  // namespace piste
