#include "start/stretch.h"

#include <algorithm>

namespace piste {

Quaterniond turned(const Log& log, double begin, double end, const Vector3d& bias) {
  Quaterniond C = Quaterniond::Identity();
  for (const ImuSample& s : range(log.imu, begin + kSameInstant, end + 1)) {
    const double from = std::max(s.time - s.interval, begin), to = std::min(s.time, end);
    if (to > from) C = C * so3_exp((to - from) * (s.dtheta / s.interval - bias));
  }
  return C.normalized();
}

}  // namespace piste
