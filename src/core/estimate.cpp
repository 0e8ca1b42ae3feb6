#include "piste/core/estimate.h"

namespace piste {
namespace {

auto segment(FullError& e, Block b) { return e.segment(full_offset(b), info(b).size); }
Vector3d three(const FullError& e, Block b) { return e.segment<3>(full_offset(b)); }

// Whether the block is part of the element of SE(3); every other block stands by itself.
constexpr bool is_motion(Block b) { return b == Block::kAttitude || b == Block::kVelocity; }

template <class E>
auto* additive_data(E& x, Block block) {
  const BlockMember& member = info(block).member;
  if (const auto* vector = std::get_if<Vector3d Estimate::*>(&member)) return (x.*(*vector)).data();
  if (const auto* six = std::get_if<Eigen::Matrix<double, 6, 1> Estimate::*>(&member)) return (x.*(*six)).data();
  if (const auto* nine = std::get_if<Eigen::Matrix<double, 9, 1> Estimate::*>(&member)) return (x.*(*nine)).data();
  if (const auto* parity = std::get_if<ParityMember>(&member)) return x.parity[parity->place].data();
  if (const auto* receiver = std::get_if<ReceiverMember>(&member)) return x.receiver[receiver->place].data();
  return &(x.*std::get<double Estimate::*>(member));
}

}  // namespace

Eigen::Map<Eigen::VectorXd> additive(Estimate& x, Block block) { return {additive_data(x, block), info(block).size}; }

Eigen::Map<const Eigen::VectorXd> additive(const Estimate& x, Block block) {
  return {additive_data(x, block), info(block).size};
}

Quaterniond& rotation(Estimate& x, Block block) { return x.*std::get<Quaterniond Estimate::*>(info(block).member); }

const Quaterniond& rotation(const Estimate& x, Block block) {
  return x.*std::get<Quaterniond Estimate::*>(info(block).member);
}

BlockValues shown_value(const Estimate& x, Block block) {
  BlockValues value = BlockValues::Zero();
  if (is_rotation(block)) {
    value.head<3>() = to_euler(rotation(x, block));
  } else {
    value.head(info(block).size) = additive(x, block);
  }
  return value;
}

namespace {

// Adds its error to every block of `blocks`; `part` gives the error of one.
template <class Blocks, class Part>
Estimate added(const Estimate& x, const Blocks& blocks, Part&& part) {
  Estimate y = x;
  for (const Block block : blocks) {
    if (is_motion(block)) continue;
    if (is_rotation(block)) {
      const Vector3d turn = part(block);
      rotation(y, block) = (so3_exp(turn) * rotation(x, block)).normalized();
    } else {
      additive(y, block) += part(block);
    }
  }
  const Vector3d theta = part(Block::kAttitude), nu = part(Block::kVelocity);
  const Quaterniond turn = so3_exp(theta);
  y.q_wb = (turn * x.q_wb).normalized();
  y.v_wb = turn * x.v_wb + so3_left_jacobian(theta) * nu;
  return y;
}

constexpr auto kAllBlocks = [] {
  std::array<Block, kBlocks.size()> all{};
  for (std::size_t i = 0; i < all.size(); ++i) all[i] = kBlocks[i].block;
  return all;
}();

}  // namespace

Estimate boxplus(const Estimate& x, const FullError& error) {
  return added(x, kAllBlocks, [&](Block block) { return error.segment(full_offset(block), info(block).size); });
}

Estimate boxplus(const Estimate& x, const StateLayout& layout, const ErrorVector& error) {
  return added(x, layout.blocks(), [&](Block block) { return error.segment(layout.offset(block), info(block).size); });
}

namespace {

// Takes the difference of every block of `blocks`; `part` is where that of one goes.
template <class Blocks, class Part>
void subtract(const Estimate& truth, const Estimate& estimate, const Blocks& blocks, Part&& part) {
  const Quaterniond turn = truth.q_wb * estimate.q_wb.conjugate();
  const Vector3d theta = so3_log(turn);
  part(Block::kAttitude) = theta;
  part(Block::kVelocity) = so3_left_jacobian_inverse(theta) * (truth.v_wb - turn * estimate.v_wb);
  for (const Block block : blocks) {
    if (is_motion(block)) continue;
    if (is_rotation(block)) {
      part(block) = so3_log(rotation(truth, block) * rotation(estimate, block).conjugate());
    } else {
      part(block) = additive(truth, block) - additive(estimate, block);
    }
  }
}

// That of (ν, θ).
Eigen::Matrix<double, 6, 6> motion_jacobian(const Vector3d& nu, const Vector3d& theta) {
  const Matrix3d turn = so3_left_jacobian(theta);
  Eigen::Matrix<double, 6, 6> J;
  J << turn, se3_left_jacobian_shift(nu, theta), Matrix3d::Zero(), turn;
  return J;
}

}  // namespace

FullError boxminus(const Estimate& truth, const Estimate& estimate) {
  FullError e = FullError::Zero();
  subtract(truth, estimate, kAllBlocks, [&](Block block) { return segment(e, block); });
  return e;
}

ErrorVector boxminus(const Estimate& truth, const Estimate& estimate, const StateLayout& layout) {
  ErrorVector e(layout.size());
  subtract(truth, estimate, layout.blocks(),
           [&](Block block) { return e.segment(layout.offset(block), info(block).size); });
  return e;
}

ResetJacobian reset_jacobian(const FullError& correction) {
  ResetJacobian G;
  G.velocity_attitude = motion_jacobian(three(correction, Block::kVelocity), three(correction, Block::kAttitude));
  for (std::size_t i = 0; i < kMountingBlocks.size(); ++i) {
    G.mountings[i] = so3_left_jacobian(three(correction, kMountingBlocks[i]));
  }
  return G;
}

ResetJacobian reset_jacobian(const StateLayout& layout, const ErrorVector& correction) {
  const auto of = [&](Block block) -> Vector3d { return correction.segment<3>(layout.offset(block)); };
  ResetJacobian G;
  G.velocity_attitude = motion_jacobian(of(Block::kVelocity), of(Block::kAttitude));
  for (std::size_t i = 0; i < kMountingBlocks.size(); ++i) {
    G.mountings[i] =
        layout.has(kMountingBlocks[i]) ? so3_left_jacobian(of(kMountingBlocks[i])) : Matrix3d::Identity().eval();
  }
  return G;
}

Estimate corrected(const Estimate& x, const StateLayout& layout, const ErrorVector& correction, bool stands) {
  Estimate after = boxplus(x, layout, correction);
  const Vector3d theta = correction.segment<3>(layout.offset(Block::kAttitude));
  if (!stands) after.v_wb = x.v_wb + correction.segment<3>(layout.offset(Block::kVelocity)) + theta.cross(x.v_wb);
  const Matrix3d C = x.R_wb();
  const Vector3d arm = C * x.lever_arm;
  after.p_wb += arm + theta.cross(arm) - after.q_wb * after.lever_arm;
  if (const int o = layout.offset(Block::kLeverArm); o >= 0) after.p_wb += C * correction.segment<3>(o);
  return after;
}

ResetJacobian transport_jacobian(const Estimate& x, const StateLayout& layout, const ErrorVector& correction,
                                 const std::optional<Standing>& standing) {
  ResetJacobian G = reset_jacobian(layout, correction);
  const Estimate after = corrected(x, layout, correction, standing.has_value());
  Matrix3d turned = G.velocity_attitude.bottomRightCorner<3, 3>();
  if (standing) {
    const double heading = standing->down.dot(so3_log(after.q_wb * standing->last_q_wb.conjugate()));
    turned = so3_exp(Vector3d(heading * standing->down)).toRotationMatrix();
  }
  G.velocity_attitude.setIdentity();
  G.velocity_attitude.bottomRightCorner<3, 3>() = turned;
  if (!standing) G.velocity_attitude.topRightCorner<3, 3>() = skew(after.v_wb) * turned - skew(x.v_wb);
  const Matrix3d C = standing ? standing->last_q_wb.toRotationMatrix() : x.R_wb(), C_after = after.R_wb();
  G.position_attitude = skew(C_after * after.lever_arm) * turned - skew(C * x.lever_arm);
  G.position_lever_arm = C - C_after;
  return G;
}

Eigen::Matrix<double, 9, 9> ordinary_from_invariant(const Estimate& x) {
  Eigen::Matrix<double, 9, 9> T = Eigen::Matrix<double, 9, 9>::Identity();
  T.block<3, 3>(full_offset(Block::kVelocity), full_offset(Block::kAttitude)) = -skew(x.v_wb);
  return T;
}

Eigen::Matrix<double, 9, 9> level_from_invariant(const Matrix3d& R_wn, const Estimate& x) {
  Eigen::Matrix<double, 9, 9> T = ordinary_from_invariant(x);
  for (int row = 0; row < 9; row += 3) T.middleRows<3>(row) = (R_wn.transpose() * T.middleRows<3>(row)).eval();
  return T;
}

FullError expand(const StateLayout& layout, const ErrorVector& error) {
  FullError full = FullError::Zero();
  for (const Block b : layout.blocks()) segment(full, b) = error.segment(layout.offset(b), info(b).size);
  return full;
}

ErrorVector select(const StateLayout& layout, const FullError& error) {
  ErrorVector selected(layout.size());
  for (const Block b : layout.blocks())
    selected.segment(layout.offset(b), info(b).size) = error.segment(full_offset(b), info(b).size);
  return selected;
}

}  // namespace piste
