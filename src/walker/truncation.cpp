#include "walker/truncation.h"

#include <algorithm>
#include <cmath>

namespace piste {
namespace {

constexpr double kLasts = 100;  // s, of a sensor whose drift has no correlation time

double correlation_time(const TriadErrors& triad) {
  return triad.drift.kind == DriftProcess::Kind::kGaussMarkov ? triad.drift.correlation_time : kLasts;
}

}  // namespace

// The density of the noise of one step of length h with the error e. None while the sum is small next to the sensor's
// own noise over the same time: it changes no sigma by more than 2.5 %, and a history keeps the noise where it changes.
Vector3d Truncation::Lasting::add(const Vector3d& e, double h, const TriadErrors& triad) {
  constexpr double kNothing = 0.05;  // of the variance of that noise
  const double kept = std::exp(-h / correlation_time(triad));
  sum = kept * sum + e;
  largest *= kept * kept;
  time = kept * time + h;
  const Vector3d square = sum.cwiseAbs2(), density = 5.0 / (3 * h) * (square - largest).cwiseMax(0);
  largest = largest.cwiseMax(square);
  return (square.array() > kNothing * time * triad.noise_variance().array()).select(density, 0);
}

StepNoise Truncation::add(const ImuSample* next, const ImuSensor& sensor) {
  constexpr double kEven = 0.01;  // of an interval: as adjoining samples are in a step
  StepNoise noise{Vector3d::Zero(), Vector3d::Zero()};
  if (next == nullptr) return noise;
  const double h = next->interval;
  const bool adjoins = count_ > 0 && !next->gap && std::abs(next->time - h - end_) < kEven * h;
  std::shift_left(last_.begin(), last_.end(), 1);
  last_.back() = {h, next->dtheta / h, next->dvel / h, adjoins};
  end_ = next->time;
  count_ = std::min(count_ + 1, static_cast<int>(last_.size()));
  if (count_ < static_cast<int>(last_.size()) ||
      !std::all_of(last_.begin() + 1, last_.end(), [](const Sample& s) { return s.adjoins; })) {
    return noise;
  }
  const Sample& middle = last_[2];
  const auto bend = [&](Vector3d Sample::*signal) -> Vector3d {
    const auto slope = [&](std::size_t a, std::size_t b) -> Vector3d {
      double time = 0.5 * (last_[a].interval + last_[b].interval);
      for (std::size_t k = a + 1; k < b; ++k) time += last_[k].interval;
      return (last_[b].*signal - last_[a].*signal) / time;
    };
    return slope(0, 4) - slope(1, 3);
  };
  const double dt = middle.interval, factor = dt * dt / 30;
  const Vector3d rate = bend(&Sample::rate), force = bend(&Sample::force);
  const Vector3d turned = factor * dt * middle.rate.cross(rate),
                 moved = factor * dt * (middle.rate.cross(force) + middle.force.cross(rate));
  noise.gyro = gyro_.add(turned, dt, sensor.gyro);
  noise.accel = accel_.add(moved, dt, sensor.accel);
  return noise;
}

}  // namespace piste
