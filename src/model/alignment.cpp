#include "model/alignment.h"

#include <cmath>

namespace piste {

Quaterniond level(const Vector3d& mean_force, double heading) {
  const double roll = std::atan2(-mean_force.y(), -mean_force.z());
  const double pitch = std::atan2(mean_force.x(), std::hypot(mean_force.y(), mean_force.z()));
  return from_euler({roll, pitch, heading});
}

}  // namespace piste
