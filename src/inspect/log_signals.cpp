#include "log_signals.h"

#include <algorithm>
#include <cmath>

#include "imu_bounds.h"
#include "piste/math/statistics.h"

namespace piste {
namespace {

constexpr double kGap = 0.3;      // s: a longer interval of an IMU is a gap
constexpr double kMissing = 2.5;  // intervals of a receiver: a longer time is a gap

double median_interval(const std::vector<double>& time) {
  std::vector<double> steps(time.size() - 1);
  for (std::size_t i = 0; i < steps.size(); ++i) steps[i] = time[i + 1] - time[i];
  return median(std::move(steps));
}

// Index of the end of the interval that contains `t`; at least 1.
std::size_t place(const std::vector<double>& time, double t) {
  const auto after = std::upper_bound(time.begin() + 1, time.end() - 1, t);
  return static_cast<std::size_t>(after - time.begin());
}

// Whether the receiver repeats its last fix somewhere from `begin` to `end`.
bool repeated(const GnssHealth& health, double begin, double end) {
  return std::any_of(health.repeated.begin(), health.repeated.end(),
                     [&](const Interval& r) { return end > r.start && begin <= r.end; });
}

// Whether the positions in between must not be used.
bool spoilt(const GnssHealth& health, double begin, double end) {
  return repeated(health, begin, end) ||
         std::any_of(health.jumps.begin(), health.jumps.end(),
                     [&](const PositionJump& j) { return j.time >= begin && j.time <= end; });
}

}  // namespace

ImuIntegral::ImuIntegral(const ImuRecording& imu) : time_(imu.time), value_(imu.time.size()) {
  interval_ = median_interval(time_);
  value_.front() = {Vector3d::Zero(), Vector3d::Zero()};
  for (std::size_t i = 1; i < time_.size(); ++i) {
    const double step = time_[i] - time_[i - 1], factor = imu.increments ? 1 : step;
    value_[i] = {value_[i - 1].angle + factor * imu.gyro[i], value_[i - 1].velocity + factor * imu.accel[i]};
    if (step > std::max(kGap, 5 * interval_)) {
      gap_starts_.push_back(time_[i - 1]);
      gap_ends_.push_back(time_[i]);
    }
  }
  find_clipped(imu);
}

void ImuIntegral::find_clipped(const ImuRecording& imu) {
  constexpr int kAgain = 5;
  std::vector<bool> at_limit(time_.size(), false);
  for (const auto* values : {&imu.gyro, &imu.accel}) {
    for (int axis = 0; axis < 3; ++axis) {
      const double least = kFewestSteps * smallest_step(*values, axis);
      for (const double sign : {1.0, -1.0}) {
        const auto value = [&](std::size_t i) { return sign * (*values)[i](axis); };
        double limit = value(0);
        for (std::size_t i = 1; i < time_.size(); ++i) limit = std::max(limit, value(i));
        int times = 0;
        for (std::size_t i = 0; i < time_.size(); ++i) times += value(i) == limit ? 1 : 0;
        if (times < kAgain || limit == 0 || std::abs(limit) < least) continue;
        for (std::size_t i = 0; i < time_.size(); ++i) at_limit[i] = at_limit[i] || value(i) == limit;
      }
    }
  }
  for (std::size_t i = 0; i < time_.size(); ++i) {
    if (at_limit[i]) clipped_.push_back(time_[i]);
  }
}

std::size_t ImuIntegral::clipped(double begin, double end) const {
  return static_cast<std::size_t>(std::upper_bound(clipped_.begin(), clipped_.end(), end) -
                                  std::upper_bound(clipped_.begin(), clipped_.end(), begin));
}

ImuIntegral::Value ImuIntegral::at(double time) const {
  const std::size_t i = place(time_, time);
  const double part = (time - time_[i - 1]) / (time_[i] - time_[i - 1]);
  const Value &a = value_[i - 1], &b = value_[i];
  return {a.angle + part * (b.angle - a.angle), a.velocity + part * (b.velocity - a.velocity)};
}

bool ImuIntegral::covers(double begin, double end) const {
  if (begin < start() || end > this->end()) return false;
  const auto gap = std::upper_bound(gap_ends_.begin(), gap_ends_.end(), begin);
  return gap == gap_ends_.end() || gap_starts_[static_cast<std::size_t>(gap - gap_ends_.begin())] >= end;
}

Track::Track(const GnssRecording& gnss, const GnssHealth& health) {
  constexpr double kHalf = 0.5, kLate = 0.03, kSure = 5;  // s; s; sigmas
  const std::vector<GeodeticFix>& fixes = gnss.fixes;
  if (fixes.size() < 3) return;
  if (2 * health.velocities > fixes.size()) {
    const VelocityFit fit = health.velocity.value_or(VelocityFit{});
    const bool late = std::abs(fit.delay) > kLate && std::abs(fit.delay) > kSure * fit.sigma_delay;
    for (const GeodeticFix& f : fixes) {
      if (!f.velocity || repeated(health, f.time, f.time)) continue;
      time_.push_back(f.time - (late ? fit.delay : 0));
      velocity_.emplace_back(fit.axes.transpose() * f.velocity->value / fit.scale);
    }
  } else {
    const World world(fixes.front().position);
    std::vector<Vector3d> p;
    p.reserve(fixes.size());
    for (const GeodeticFix& f : fixes) p.push_back(world.from_geodetic(f.position));
    const auto reach =
        std::max<std::size_t>(1, static_cast<std::size_t>(std::lround(kHalf / health.sampling.interval)));
    for (std::size_t i = reach; i + reach < fixes.size(); ++i) {
      const double dt = fixes[i + reach].time - fixes[i - reach].time;
      if (dt > kMissing * static_cast<double>(2 * reach) * health.sampling.interval) continue;
      if (spoilt(health, fixes[i - reach].time, fixes[i + reach].time)) continue;
      time_.push_back(fixes[i].time);
      velocity_.emplace_back((p[i + reach] - p[i - reach]) / dt);
    }
  }
  interval_ = health.sampling.interval;
  if (time_.size() < 3) time_.clear();
}

std::optional<Vector3d> Track::velocity(double time) const {
  if (empty() || time < start() || time > end()) return std::nullopt;
  const std::size_t i = place(time_, time);
  const double step = time_[i] - time_[i - 1];
  if (step > kMissing * interval_) return std::nullopt;
  const double part = (time - time_[i - 1]) / step;
  return Vector3d(velocity_[i - 1] + part * (velocity_[i] - velocity_[i - 1]));
}

}  // namespace piste
