#include "model/recent_steps.h"

#include <algorithm>

namespace piste {

void RecentSteps::add(const ImuStep& step) {
  if (count_ > 0 && sums_[newest_].dt < kBin) {
    Sum& sum = sums_[newest_];
    sum.dt += step.dt;
    sum.dtheta += step.dtheta;
    sum.dvel += step.dvel;
    return;
  }
  newest_ = (newest_ + 1) % kMost;
  count_ = std::min(count_ + 1, kMost);
  sums_[newest_] = {step.dt, step.dtheta, step.dvel};
}

std::optional<LaggedMotion> RecentSteps::over(double tau, const Estimate& x) const {
  const auto corrected = [&](std::size_t k) {
    const Sum& s = back(k);
    return correct({s.dt, s.dtheta, s.dvel, Vector3d::Zero(), Vector3d::Zero()}, x);
  };
  Quaterniond turn = Quaterniond::Identity();  // from the axes at the beginning of what is summed to those at its end
  Vector3d velocity = Vector3d::Zero(), position = Vector3d::Zero();
  double age = 0;
  for (std::size_t k = 0; k < count_; ++k) {
    const ImuStep s = corrected(k);
    const double taken = std::min(s.dt, tau - age), part = taken / s.dt;
    const Quaterniond half = so3_exp(-0.5 * part * s.dtheta);
    const Vector3d change = turn * (half * (part * s.dvel));
    velocity += change;
    position += (tau - age - 0.5 * taken) * change;
    turn = turn * half * half;
    age += taken;
    if (age < tau) continue;
    // The rate between the means of this sum and of the one on the other side of the time.
    const double beyond = taken - 0.5 * s.dt;
    const bool older = beyond > 0;
    Vector3d rate = s.mean_rate();
    if (older ? k + 1 < count_ : k > 0) {
      const ImuStep other = corrected(older ? k + 1 : k - 1);
      rate += 2 * std::abs(beyond) / (s.dt + other.dt) * (other.mean_rate() - s.mean_rate());
    }
    return LaggedMotion{-so3_log(turn) / tau, velocity / tau, 2 / (tau * tau) * position, rate};
  }
  return std::nullopt;
}

}  // namespace piste
