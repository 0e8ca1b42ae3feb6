#include "piste/core/estimate.h"

namespace piste {
namespace {

auto segment(FullError& e, Block b) { return e.segment(full_offset(b), info(b).size); }
Vector3d three(const FullError& e, Block b) { return e.segment<3>(full_offset(b)); }

template <class E>
auto* additive_data(E& x, Block block) {
  switch (block) {
    case Block::kPosition:
      return x.p_wb.data();
    case Block::kVelocity:
      return x.v_wb.data();
    case Block::kGyroBias:
      return x.gyro_bias.data();
    case Block::kAccelBias:
      return x.accel_bias.data();
    case Block::kGyroDrift:
      return x.gyro_drift.data();
    case Block::kAccelDrift:
      return x.accel_drift.data();
    case Block::kGyroScale:
      return x.gyro_scale.data();
    case Block::kAccelScale:
      return x.accel_scale.data();
    case Block::kLeverArm:
      return x.lever_arm.data();
    case Block::kGnssPositionDrift:
      return x.gnss_position_drift.data();
    case Block::kGnssDelay:
      return &x.gnss_delay;
    case Block::kAttitudeDrift:
      return x.attitude_drift.data();
    case Block::kBoresightDrift:
      return x.boresight_drift.data();
    case Block::kAttitude:
    case Block::kBoresight:
      break;
  }
  return static_cast<decltype(x.p_wb.data())>(nullptr);
}

constexpr bool is_group_block(Block b) {
  return b == Block::kAttitude || b == Block::kBoresight || b == Block::kVelocity;
}

}  // namespace

Eigen::Map<Eigen::VectorXd> additive(Estimate& x, Block block) { return {additive_data(x, block), info(block).size}; }

Eigen::Map<const Eigen::VectorXd> additive(const Estimate& x, Block block) {
  return {additive_data(x, block), info(block).size};
}

Estimate boxplus(const Estimate& x, const FullError& error) {
  Estimate y = x;
  const Vector3d theta = three(error, Block::kAttitude);
  const Quaterniond rotation = so3_exp(theta);
  y.q_wb = (rotation * x.q_wb).normalized();
  y.v_wb = rotation * x.v_wb + so3_left_jacobian(theta) * three(error, Block::kVelocity);
  y.q_rb = (so3_exp(three(error, Block::kBoresight)) * x.q_rb).normalized();
  for (const BlockInfo& row : kBlocks) {
    if (!is_group_block(row.block)) additive(y, row.block) += error.segment(full_offset(row.block), row.size);
  }
  return y;
}

Estimate boxplus(const Estimate& x, const StateLayout& layout, const ErrorVector& error) {
  return boxplus(x, expand(layout, error));
}

FullError boxminus(const Estimate& truth, const Estimate& estimate) {
  FullError e = FullError::Zero();
  const Quaterniond rotation = truth.q_wb * estimate.q_wb.conjugate();
  const Vector3d theta = so3_log(rotation);
  segment(e, Block::kAttitude) = theta;
  segment(e, Block::kVelocity) = so3_left_jacobian_inverse(theta) * (truth.v_wb - rotation * estimate.v_wb);
  segment(e, Block::kBoresight) = so3_log(truth.q_rb * estimate.q_rb.conjugate());
  for (const BlockInfo& row : kBlocks) {
    if (!is_group_block(row.block)) segment(e, row.block) = additive(truth, row.block) - additive(estimate, row.block);
  }
  return e;
}

ResetJacobian reset_jacobian(const FullError& correction) {
  using Matrix6d = Eigen::Matrix<double, 6, 6>;
  Matrix6d ad = Matrix6d::Zero();
  const Matrix3d theta = skew(three(correction, Block::kAttitude));
  ad.block<3, 3>(0, 0) = theta;
  ad.block<3, 3>(0, 3) = skew(three(correction, Block::kVelocity));
  ad.block<3, 3>(3, 3) = theta;
  // J_l = Σ ad^n / (n+1)!, summed until terms no longer count: a few for most corrections, some thirty for a
  // turn by π. The bound ends the sum of a correction that is not finite.
  constexpr int kMost = 100;
  constexpr double kNothing = 1e-18;
  Matrix6d term = Matrix6d::Identity(), sum = term;
  for (int n = 1; n <= kMost; ++n) {
    term = (term * ad / (n + 1)).eval();
    sum += term;
    if (term.cwiseAbs().maxCoeff() < kNothing) break;
  }
  return {sum, so3_left_jacobian(three(correction, Block::kBoresight))};
}

Eigen::Matrix<double, 9, 9> ordinary_from_invariant(const Estimate& x) {
  Eigen::Matrix<double, 9, 9> T = Eigen::Matrix<double, 9, 9>::Identity();
  T.block<3, 3>(full_offset(Block::kVelocity), full_offset(Block::kAttitude)) = -skew(x.v_wb);
  return T;
}

FullError expand(const StateLayout& layout, const ErrorVector& error) {
  FullError full = FullError::Zero();
  for (const Block b : layout.blocks()) segment(full, b) = error.segment(layout.offset(b), info(b).size);
  return full;
}

}  // namespace piste
