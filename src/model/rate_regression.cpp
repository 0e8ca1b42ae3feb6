#include "piste/model/rate_regression.h"

#include <Eigen/LU>
#include <algorithm>

#include "piste/model/strapdown.h"

namespace piste {
namespace {

constexpr double kRounding = 1e-9;  // of the mean square: an axis without motion and noise
constexpr double kNoRate = 1e-30;   // rad²/s²

}  // namespace

void RateRegression::add(const ImuSample& sample, const Vector3d& beside, const Estimate& x) {
  if (beside.isZero(0)) return;
  const Vector3d force = sample.dvel / sample.interval;
  const Vector3d rate = corrected_rate(sample.dtheta / sample.interval, force, x),
                 other = corrected_rate(beside, force, x);
  const double part = std::min(1.0, std::max(sample.interval / kMemory, 1 / ++samples_));
  cross_ += part * (rate * other.transpose() - cross_);
  square_ += part * (other * other.transpose() - square_);
}

Matrix3d RateRegression::matrix() const {
  if (samples_ == 0) return Matrix3d::Identity();
  Matrix3d square = square_;
  square.diagonal().array() += kRounding * square_.trace() + kNoRate;
  return cross_ * square.inverse();
}

}  // namespace piste
