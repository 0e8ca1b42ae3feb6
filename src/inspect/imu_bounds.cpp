#include "inspect/imu_bounds.h"

#include <cmath>
#include <cstddef>

namespace piste {

double smallest_step(const std::vector<Vector3d>& values, int axis) {
  double smallest = 0;
  for (std::size_t i = 1; i < values.size(); ++i) {
    const double step = std::abs(values[i](axis) - values[i - 1](axis));
    if (step > 1e-12 * std::abs(values[i](axis)) && step > 0 && (smallest == 0 || step < smallest)) smallest = step;
  }
  return smallest;
}

}  // namespace piste
