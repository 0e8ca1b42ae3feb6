#include "piste/model/imu_errors.h"

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

double change_sigma(const DriftProcess& process, double lapse) {
  switch (process.kind) {
    case DriftProcess::Kind::kNone:
      return 0;
    case DriftProcess::Kind::kRandomWalk:
      return process.density * std::sqrt(lapse);
    case DriftProcess::Kind::kGaussMarkov:
      return process.sigma * std::sqrt(-2 * std::expm1(-lapse / process.correlation_time));
  }
  return 0;
}

}  // namespace piste
