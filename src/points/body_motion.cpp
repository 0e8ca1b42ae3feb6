#include "points/body_motion.h"

#include "piste/model/strapdown.h"

namespace piste {

std::pair<Vector3d, Vector3d> SampleMotion::operator()(double time, const Estimate& x) {
  const ImuSample& s = log_->imu[at_(time)];
  const ImuStep step = correct({s.interval, s.dtheta, s.dvel, Vector3d::Zero(), Vector3d::Zero()}, x);
  return {step.mean_rate(), step.mean_force()};
}

}  // namespace piste
