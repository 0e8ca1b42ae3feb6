#include "fit/reference_errors.h"

#include <algorithm>
#include <cmath>

#include "piste/math/statistics.h"

namespace piste {
namespace {

constexpr int kOffset = 0, kDrift = 1, kBoresight = 2, kLeverArm = 5, kBias = 8, kScale = 9;
static_assert(AlignmentLayout::kClockOffset == kOffset && AlignmentLayout::kClockDrift == kDrift &&
              AlignmentLayout::kBoresight == kBoresight && AlignmentLayout::kLeverArm == kLeverArm);

double bias_variance(const TriadErrors& e) {
  return square(e.bias) + (e.drift.kind == DriftProcess::Kind::kGaussMarkov ? square(e.drift.sigma) : 0);
}

}  // namespace

ReferenceErrors::ReferenceErrors(const AlignedImus& imus, const Alignment* alignment, const ImuSensor* reference)
    : imus_(imus) {
  if (alignment) {
    R_br_ = alignment->q_rb.toRotationMatrix().transpose();
    Covariance P = Covariance::Zero();
    P.topLeftCorner<kBias, kBias>() = alignment->covariance.topLeftCorner<kBias, kBias>();
    for (int i = 0; i < kBias; ++i) {
      if (!std::isfinite(P(i, i))) P(i, i) = 0;  // off the diagonal it is 0
    }
    P_force_ = P_rate_ = P;
  }
  if (reference) {
    P_force_(kBias, kBias) = bias_variance(reference->accel);
    P_force_(kScale, kScale) = square(reference->accel.scale);
    P_rate_(kBias, kBias) = bias_variance(reference->gyro);
    P_rate_(kScale, kScale) = square(reference->gyro.scale);
  }
}

Vector3d ReferenceErrors::rate_of_change(const std::vector<Vector3d>& signal, std::size_t i) const {
  const std::size_t before = i > 0 ? i - 1 : i, after = std::min(i + 1, signal.size() - 1);
  if (!imus_.usable[before] || !imus_.usable[after]) return Vector3d::Zero();
  return (signal[after] - signal[before]) / (imus_.time[after] - imus_.time[before]);
}

ReferenceErrors::Row ReferenceErrors::row(std::size_t i, int axis) const {
  const bool force = axis < 3;
  const int k = axis % 3;
  const auto& signal = force ? imus_.reference_accel : imus_.reference_gyro;
  const Vector3d& x = signal[i];
  const double change = rate_of_change(signal, i)(k);
  Row D = Row::Zero();
  D(kOffset) = -change;  // a larger offset is an earlier time of the reference
  D(kDrift) = -change * (imus_.time[i] - imus_.time.front());
  const Vector3d& w = imus_.reference_gyro[i];
  const Vector3d w_dot = rate_of_change(imus_.reference_gyro, i);
  for (int j = 0; j < 3; ++j) {
    const Vector3d u = R_br_.col(j);  // axis j of r, in b
    D(kBoresight + j) = x.cross(u)(k);
    if (force) D(kLeverArm + j) = (w_dot.cross(u) + w.cross(w.cross(u)))(k);
  }
  D(kBias) = 1;
  D(kScale) = x(k);
  return D;
}

ReferenceErrors::Covariance ReferenceErrors::covariance(int axis) const { return axis < 3 ? P_force_ : P_rate_; }

}  // namespace piste
