#include "piste/model/dynamics.h"

namespace piste {
namespace {

constexpr int kRho = full_offset(Block::kPosition);
constexpr int kNu = full_offset(Block::kVelocity);
constexpr int kTheta = full_offset(Block::kAttitude);

// What a block contributes to (e_g, e_a): its half, and the factor of each axis.
struct ImuBlock {
  Block block;
  int half;
  bool scale;
};
constexpr ImuBlock kImuBlocks[] = {{Block::kGyroBias, 0, false},  {Block::kAccelBias, 3, false},
                                   {Block::kGyroDrift, 0, false}, {Block::kAccelDrift, 3, false},
                                   {Block::kGyroScale, 0, true},  {Block::kAccelScale, 3, true}};

Vector3d factor_of(const ImuBlock& b, const Transition& t) {
  if (!b.scale) return Vector3d::Ones();
  return b.half == 0 ? t.rate : t.force;
}

std::size_t slot(Block b) { return static_cast<std::size_t>(index_of(b)); }

}  // namespace

Transition linearize(const Estimate& x, const Estimate& end, const ImuStep& s, const Vector3d& earth_rate,
                     const Gravity& gravity, const StepNoise& noise, bool still) {
  Transition t;
  t.rate = s.mean_rate();
  t.force = s.mean_force();
  t.decay.fill(1);
  t.variance.fill(Vector3d::Zero());

  const double dt = s.dt;
  const Matrix3d R_mid = (x.q_wb * so3_exp(0.5 * s.dtheta)).toRotationMatrix();
  const Vector3d v_mid = still ? Vector3d::Zero().eval() : (0.5 * (x.v_wb + end.v_wb)).eval();
  const Matrix3d V = skew(v_mid), E = skew(earth_rate);

  Matrix9d A = Matrix9d::Zero();
  A.block<3, 3>(kRho, kNu).setIdentity();
  A.block<3, 3>(kRho, kTheta) = -V;
  A.block<3, 3>(kNu, kRho) = gravity.gradient;
  A.block<3, 3>(kNu, kNu) = -2 * E;
  A.block<3, 3>(kNu, kTheta) = skew(gravity.value) + V * E;
  A.block<3, 3>(kTheta, kTheta) = -E;
  const Matrix9d integral = dt * (Matrix9d::Identity() + 0.5 * dt * A);  // ∫Φ
  t.navigation.noalias() = A * integral;
  t.navigation.diagonal().array() += 1;

  Matrix96d B = Matrix96d::Zero();
  const Matrix3d gyro = -R_mid * (1 + x.gyro_scale.array()).inverse().matrix().asDiagonal();
  B.block<3, 3>(kTheta, 0) = gyro;
  B.block<3, 3>(kNu, 0) = V * gyro;
  B.block<3, 3>(kNu, 3) = -R_mid * (1 + x.accel_scale.array()).inverse().matrix().asDiagonal();
  t.imu.noalias() = integral * B;

  // Trapezoid of ∫ Φ B N Bᵀ Φᵀ; ∫Φ B / dt stands for the middle of the step.
  Eigen::Matrix<double, 6, 1> density;
  density << noise.gyro, noise.accel;
  const Matrix96d middle = t.imu / dt;
  t.noise.noalias() = middle * (dt * density).asDiagonal() * middle.transpose();
  return t;
}

void add_processes(Transition& t, const StateLayout& layout, const FilterOptions& options, double dt) {
  const auto add = [&](Block b, const DriftProcess& process, const Vector3d& weight) {
    if (!layout.has(b)) return;
    const DiscreteProcess d = discretise(process, dt);
    t.decay[slot(b)] = d.transition;
    t.variance[slot(b)] = d.variance * weight;
  };
  add(Block::kGyroDrift, options.sensor.gyro.drift, Vector3d::Ones());
  add(Block::kAccelDrift, options.sensor.accel.drift, Vector3d::Ones());
  const auto coloured = [&](Block b, const std::optional<GaussMarkov>& process) {
    if (!process) return;
    add(b, {DriftProcess::Kind::kGaussMarkov, 1, process->correlation_time, 0}, process->sigma.cwiseAbs2());
  };
  for (const GnssOptions& g : options.gnss) coloured(Block::kGnssPositionDrift, g.drift);
  for (const AttitudeOptions& a : options.attitude) coloured(Block::kAttitudeDrift, a.drift);
}

void propagate(Covariance& P, const StateLayout& layout, const Transition& t) {
  const int n = layout.size();
  // Rows of the navigation error after the step, against every error before it.
  Eigen::Matrix<double, 9, Eigen::Dynamic, 0, 9, kFullSize> top(9, n);
  for (int j = 0; j < n; ++j) {
    Eigen::Matrix<double, 6, 1> e = Eigen::Matrix<double, 6, 1>::Zero();
    for (const ImuBlock& b : kImuBlocks) {
      if (layout.has(b.block)) {
        e.segment<3>(b.half) += factor_of(b, t).cwiseProduct(P.col(j).segment<3>(layout.offset(b.block)));
      }
    }
    top.col(j).noalias() = t.navigation * P.col(j).head<9>();
    top.col(j).noalias() += t.imu * e;
  }
  Matrix96d against_imu = Matrix96d::Zero();
  for (const ImuBlock& b : kImuBlocks) {
    if (!layout.has(b.block)) continue;
    against_imu.middleCols<3>(b.half) += top.middleCols<3>(layout.offset(b.block)) * factor_of(b, t).asDiagonal();
  }
  Matrix9d corner = t.noise;
  corner.noalias() += top.leftCols<9>() * t.navigation.transpose();
  corner.noalias() += against_imu * t.imu.transpose();
  P.topLeftCorner<9, 9>() = 0.5 * (corner + corner.transpose());
  P.topRightCorner(9, n - 9) = top.rightCols(n - 9);
  for (const Block b : layout.blocks()) {
    const double f = t.decay[slot(b)];
    const int o = layout.offset(b), size = info(b).size;
    if (f != 1) {
      P.middleCols(o, size) *= f;
      P.block(o, 9, size, n - 9) *= f;
    }
    P.diagonal().segment(o, size) += t.variance[slot(b)].head(size);
  }
  P.bottomLeftCorner(n - 9, 9) = P.topRightCorner(9, n - 9).transpose();
}

void propagate_adjoint(ErrorVector& lambda, Covariance& Lambda, const StateLayout& layout, const Transition& t) {
  const int n = layout.size();
  // Λ Φ: the columns of navigation and of e mix only into their own.
  const auto mix_columns = [&](auto& M) {
    Eigen::Matrix<double, Eigen::Dynamic, 9, 0, kFullSize, 9> head = M.template leftCols<9>();
    Eigen::Matrix<double, Eigen::Dynamic, 6, 0, kFullSize, 6> through(M.rows(), 6);
    through.noalias() = head.lazyProduct(t.imu);
    M.template leftCols<9>() = head.lazyProduct(t.navigation);
    for (const Block b : layout.blocks()) {
      const double f = t.decay[slot(b)];
      if (f != 1) M.middleCols(layout.offset(b), info(b).size) *= f;
    }
    for (const ImuBlock& b : kImuBlocks) {
      if (!layout.has(b.block)) continue;
      M.template middleCols<3>(layout.offset(b.block)) +=
          through.template middleCols<3>(b.half) * factor_of(b, t).asDiagonal();
    }
  };
  mix_columns(Lambda);
  Lambda.transposeInPlace();
  mix_columns(Lambda);
  for (int j = 1; j < n; ++j) {
    for (int i = 0; i < j; ++i) Lambda(i, j) = Lambda(j, i) = 0.5 * (Lambda(i, j) + Lambda(j, i));
  }
  Eigen::Matrix<double, 1, Eigen::Dynamic, Eigen::RowMajor, 1, kFullSize> row = lambda.transpose();
  mix_columns(row);
  lambda = row.transpose();
}

Covariance dense_transition(const StateLayout& layout, const Transition& t) {
  Covariance Phi = Covariance::Identity(layout.size(), layout.size());
  for (const Block b : layout.blocks()) {
    Phi.diagonal().segment(layout.offset(b), info(b).size) *= t.decay[slot(b)];
  }
  Phi.topLeftCorner<9, 9>() = t.navigation;
  for (const ImuBlock& b : kImuBlocks) {
    if (!layout.has(b.block)) continue;
    Phi.block<9, 3>(0, layout.offset(b.block)) = t.imu.middleCols<3>(b.half) * factor_of(b, t).asDiagonal();
  }
  return Phi;
}

void decay(Estimate& x, const StateLayout& layout, const Transition& t) {
  for (const Block b : {Block::kGyroDrift, Block::kAccelDrift, Block::kGnssPositionDrift, Block::kAttitudeDrift}) {
    if (layout.has(b)) additive(x, b) *= t.decay[slot(b)];
  }
}

}  // namespace piste
