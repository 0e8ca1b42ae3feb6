#include "model/imu_errors.h"

#include <algorithm>
#include <cmath>

namespace piste {

DiscreteProcess discretise(const DriftProcess& process, double dt) {
  switch (process.kind) {
    case DriftProcess::Kind::kNone:
      return {};
    case DriftProcess::Kind::kRandomWalk:
      return {1, process.density * process.density * dt};
    case DriftProcess::Kind::kGaussMarkov: {
      const double x = dt / process.correlation_time;
      return {std::exp(-x), -process.sigma * process.sigma * std::expm1(-2 * x)};
    }
  }
  return {};
}

double initial_sigma(const DriftProcess& process) {
  return process.kind == DriftProcess::Kind::kGaussMarkov ? process.sigma : 0;
}

double change_sigma(const DriftProcess& process, double a, double gap, double b) {
  switch (process.kind) {
    case DriftProcess::Kind::kNone:
      return 0;
    case DriftProcess::Kind::kRandomWalk:
      return process.density * std::sqrt(a / 3 + gap + b / 3);
    case DriftProcess::Kind::kGaussMarkov: {
      const double x = a / process.correlation_time, y = b / process.correlation_time;
      const auto variance = [](double t) { return 2 / (t * t) * (t + std::expm1(-t)); };
      const double covariance = std::exp(-gap / process.correlation_time) * std::expm1(-x) * std::expm1(-y) / (x * y);
      return process.sigma * std::sqrt(std::max(0.0, variance(x) + variance(y) - 2 * covariance));
    }
  }
  return 0;
}

}  // namespace piste
