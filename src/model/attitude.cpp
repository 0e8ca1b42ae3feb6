#include "piste/model/attitude.h"

namespace piste {

namespace {

Quaterniond reference_of(const Estimate& x) {
  return so3_exp(x.attitude_drift) * x.q_wb * (so3_exp(x.boresight_drift) * x.q_rb).conjugate();
}

}  // namespace

Linearization linearize_attitude(const AttitudeFix& fix, const Vector3d& white, const Estimate& x,
                                 const Estimate* after) {
  const Quaterniond predicted = reference_of(x);
  Linearization lin;
  lin.observes = Block::kAttitude;
  lin.residual = so3_log(fix.q_wr * predicted.conjugate());
  const Matrix3d noise = so3_left_jacobian_inverse(lin.residual) * white.asDiagonal();
  lin.covariance = noise * fix.covariance * noise.transpose();

  Matrix3d J = so3_left_jacobian_inverse(-lin.residual), R_wr = J * predicted.toRotationMatrix();
  if (after != nullptr) {
    const Vector3d turn = so3_log(reference_of(*after) * predicted.conjugate());
    J.setIdentity();
    R_wr = (so3_exp(0.5 * turn) * predicted).toRotationMatrix();
  }
  lin.add(Block::kAttitude, J * so3_exp(x.attitude_drift).toRotationMatrix());
  lin.add(Block::kBoresight, -R_wr * so3_exp(x.boresight_drift).toRotationMatrix());
  lin.add(Block::kAttitudeDrift, J * so3_left_jacobian(x.attitude_drift));
  lin.add(Block::kBoresightDrift, -R_wr * so3_left_jacobian(x.boresight_drift));
  return lin;
}

std::optional<Linearization> ReferenceAttitudes::linearize(const AttitudeFix& fix, int sensor, int,
                                                           const MeasurementContext& context, const Estimate& x,
                                                           const Estimate* after) {
  const AttitudeOptions& reference = context.options.attitude[static_cast<std::size_t>(sensor)];
  return linearize_attitude(fix, reference.drift ? reference.white : Vector3d::Ones(), x, after);
}

}  // namespace piste
