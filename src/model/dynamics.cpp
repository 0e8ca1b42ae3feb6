#include "piste/model/dynamics.h"

namespace piste {
namespace {

constexpr int kRho = full_offset(Block::kPosition);
constexpr int kNu = full_offset(Block::kVelocity);
constexpr int kTheta = full_offset(Block::kAttitude);

// How a block adds to (e_g, e_a): to which of the two, and with which factor on each axis.
struct ImuBlock {
  Block block;
  int half;
  bool scale;
};
constexpr ImuBlock kImuBlocks[] = {{Block::kGyroBias, 0, false},  {Block::kAccelBias, 3, false},
                                   {Block::kGyroDrift, 0, false}, {Block::kAccelDrift, 3, false},
                                   {Block::kGyroScale, 0, true},  {Block::kAccelScale, 3, true}};

Vector3d factor_of(const ImuBlock& b, const Transition& t) {
  if (!b.scale) return Vector3d::Constant(t.bias);
  return b.half == 0 ? t.rate : t.force;
}

std::size_t at(int k) { return static_cast<std::size_t>(k); }
std::size_t slot(Block b) { return at(index_of(b)); }

// Φ state by state, beyond the navigation states. Each state decays, and some act on the navigation rows, through one
// column of `mixer` = (navigation | imu).
constexpr int kNavigation = 9;
constexpr int kInputs = 15;  // navigation, e_g and e_a
using Mixer = Eigen::Matrix<double, kNavigation, kInputs>;
struct Structure {
  Mixer mixer;
  std::array<double, kFullSize> decay, factor;
  std::array<int, kFullSize> input;  // column of the mixer, −1: none

  Structure(const StateLayout& layout, const Transition& t) {
    mixer << t.navigation, t.imu;
    for (const Block b : layout.blocks()) {
      const double f = t.decay[slot(b)];
      for (int k = layout.offset(b); k < layout.offset(b) + info(b).size; ++k) {
        decay[at(k)] = f;
        input[at(k)] = -1;
      }
    }
    for (const ImuBlock& b : kImuBlocks) {
      if (!layout.has(b.block)) continue;
      const Vector3d factors = factor_of(b, t);
      for (int k = 0; k < 3; ++k) {
        factor[at(layout.offset(b.block) + k)] = factors(k);
        input[at(layout.offset(b.block) + k)] = kNavigation + b.half + k;
      }
    }
  }
};

template <int N>
using Columns = Eigen::Matrix<double, kFullSize, N>;

// out = in Wᵀ over the first n rows. Plain loops: the compiler vectorises along the rows, and every sum keeps its
// order, so that wider registers give the same bits.
template <int Out, int In>
[[gnu::always_inline]] inline void combine(const Eigen::Matrix<double, Out, In>& W, const Columns<In>& in, int n,
                                           Columns<Out>& out) {
  for (int i = 0; i < Out; ++i) {
    double w[In];
    for (int k = 0; k < In; ++k) w[k] = W(i, k);
    const double* x = in.data();
    double* y = out.data() + i * kFullSize;
    for (int r = 0; r < n; ++r) {
      double sum = w[0] * x[r];
      for (int k = 1; k < In; ++k) sum += w[k] * x[k * kFullSize + r];
      y[r] = sum;
    }
  }
}

#if defined(__x86_64__) && defined(__gnu_linux__)
#define PISTE_WIDE __attribute__((target_clones("avx2", "default")))
#else
#define PISTE_WIDE
#endif

PISTE_WIDE void onto_navigation(const Mixer& mixer, const Columns<kInputs>& in, int n, Columns<kNavigation>& out) {
  combine(mixer, in, n, out);
}

PISTE_WIDE void onto_inputs(const Mixer& mixer, const Columns<kNavigation>& in, int n, Columns<kInputs>& out) {
  combine<kInputs, kNavigation>(mixer.transpose(), in, n, out);
}

// λ ← Φᵀ λ of the first n rows.
void adjoint(ErrorVector& lambda, int n, const Structure& s) {
  const Eigen::Matrix<double, kInputs, 1> seen = s.mixer.transpose() * lambda.head<kNavigation>();
  lambda.head<kNavigation>() = seen.head<kNavigation>();
  for (int k = kNavigation; k < n; ++k) {
    lambda(k) *= s.decay[at(k)];
    if (s.input[at(k)] >= 0) lambda(k) += s.factor[at(k)] * seen(s.input[at(k)]);
  }
}

}  // namespace

Transition linearize(const Estimate& x, const Estimate& end, const ImuStep& s, const Vector3d& earth_rate,
                     const Gravity& gravity, const StepNoise& noise, const Vector3d* standing) {
  Transition t;
  // At rest the measured rate is noise alone, and would give false information on the scale.
  t.rate = standing ? Vector3d::Zero().eval() : s.mean_rate();
  t.force = standing ? *standing : s.mean_force();
  t.decay.fill(1);
  t.variance.fill(Vector3d::Zero());

  const double dt = s.dt;
  const Matrix3d R_mid = (x.q_wb * so3_exp(0.5 * s.dtheta)).toRotationMatrix();
  const Vector3d v_mid = standing ? Vector3d::Zero().eval() : (0.5 * (x.v_wb + end.v_wb)).eval();
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

  // ∫ Φ B N Bᵀ Φᵀ over the step, by its value in the middle of the step, where Φ B is nearly ∫Φ B / dt.
  Eigen::Matrix<double, 6, 1> density;
  density << noise.gyro, noise.accel;
  const Matrix96d middle = t.imu / dt;
  t.noise.noalias() = middle * (dt * density).asDiagonal() * middle.transpose();
  return t;
}

Transition mend_rate(const Estimate& x, const Vector3d& noise_angle) {
  Transition t;
  t.navigation.setIdentity();
  t.imu.setZero();
  const Matrix3d R = x.R_wb();
  const Matrix3d gyro = -R * (1 + x.gyro_scale.array()).inverse().matrix().asDiagonal();
  t.imu.block<3, 3>(kTheta, 0) = gyro;
  t.imu.block<3, 3>(kNu, 0) = skew(x.v_wb) * gyro;
  t.rate = R.transpose() * noise_angle;
  t.force.setZero();
  t.bias = 0;
  t.noise.setZero();
  t.decay.fill(1);
  t.variance.fill(Vector3d::Zero());
  return t;
}

void add_processes(Transition& t, const StateLayout& layout, const FilterOptions& options, double dt) {
  for (const Block b : layout.blocks()) {
    if (!info(b).process) continue;
    const std::optional<BlockProcess> process = info(b).process(options);
    if (!process) continue;
    const DiscreteProcess d = discretise(process->law, dt);
    t.decay[slot(b)] = d.transition;
    t.variance[slot(b)] = d.variance * process->weight;
  }
}

void propagate(Covariance& P, const StateLayout& layout, const Transition& t) {
  const int n = layout.size();
  const Structure s(layout, t);
  // Covariance of every error before the step (rows) with the inputs of the navigation rows, then with the navigation
  // rows after the step.
  Columns<kInputs> inputs;
  inputs.leftCols<kNavigation>().topRows(n) = P.leftCols<kNavigation>();
  inputs.rightCols<6>().topRows(n).setZero();
  for (int k = kNavigation; k < n; ++k) {
    if (s.input[at(k)] >= 0) inputs.col(s.input[at(k)]).head(n) += s.factor[at(k)] * P.col(k);
  }
  Columns<kNavigation> after;
  onto_navigation(s.mixer, inputs, n, after);

  // The same for the navigation rows themselves.
  inputs.leftCols<kNavigation>().topRows<kNavigation>() = after.topRows<kNavigation>().transpose();
  inputs.rightCols<6>().topRows<kNavigation>().setZero();
  for (int k = kNavigation; k < n; ++k) {
    if (s.input[at(k)] < 0) continue;
    inputs.col(s.input[at(k)]).head<kNavigation>() += s.factor[at(k)] * after.row(k).transpose();
  }
  Columns<kNavigation> corner;
  onto_navigation(s.mixer, inputs, kNavigation, corner);
  for (int j = 0; j < kNavigation; ++j) {
    for (int i = 0; i <= j; ++i) P(i, j) = P(j, i) = 0.5 * (corner(i, j) + corner(j, i)) + t.noise(i, j);
  }

  const int others = n - kNavigation;
  for (const Block b : layout.blocks()) {
    const double f = t.decay[slot(b)];
    if (f == 1) continue;
    const int o = layout.offset(b), size = info(b).size;
    after.middleRows(o, size) *= f;
    P.block(kNavigation, o, others, size) *= f;
    P.block(o, kNavigation, size, others) *= f;
  }
  for (int j = 0; j < kNavigation; ++j) {
    P.col(j).tail(others) = after.col(j).segment(kNavigation, others);
    P.row(j).tail(others) = P.col(j).tail(others).transpose();
  }
  for (const Block b : layout.blocks()) {
    const int size = info(b).size;
    P.diagonal().segment(layout.offset(b), size) += t.variance[slot(b)].head(size);
  }
}

void propagate(ErrorVector& m, const StateLayout& layout, const Transition& t) {
  const Structure s(layout, t);
  Eigen::Matrix<double, kInputs, 1> inputs = Eigen::Matrix<double, kInputs, 1>::Zero();
  inputs.head<kNavigation>() = m.head<kNavigation>();
  for (int k = kNavigation; k < layout.size(); ++k) {
    if (s.input[at(k)] >= 0) inputs(s.input[at(k)]) += s.factor[at(k)] * m(k);
    m(k) *= s.decay[at(k)];
  }
  m.head<kNavigation>() = s.mixer * inputs;
}

void propagate_adjoint(ErrorVector& lambda, Covariance& Lambda, const StateLayout& layout, const Transition& t) {
  const int n = layout.size();
  const Structure s(layout, t);
  // Λ Φ by columns: first those of the inputs; the column of each state is then made of them.
  Columns<kNavigation> navigation;
  navigation.topRows(n) = Lambda.leftCols<kNavigation>();
  Columns<kInputs> through;
  onto_inputs(s.mixer, navigation, n, through);
  // The navigation rows of Λ Φ, stored as columns, and Φᵀ times them.
  navigation.topRows<kNavigation>() = through.topLeftCorner<kNavigation, kNavigation>().transpose();
  for (int k = kNavigation; k < n; ++k) {
    navigation.row(k) = s.decay[at(k)] * navigation.row(k);
    if (s.input[at(k)] < 0) continue;
    navigation.row(k) += s.factor[at(k)] * through.col(s.input[at(k)]).head<kNavigation>().transpose();
  }
  Columns<kInputs> both;
  onto_inputs(s.mixer, navigation, n, both);

  for (int j = 0; j < kNavigation; ++j) {
    for (int i = 0; i <= j; ++i) Lambda(i, j) = Lambda(j, i) = 0.5 * (both(i, j) + both(j, i));
    Lambda.col(j).tail(n - kNavigation) = both.col(j).segment(kNavigation, n - kNavigation);
    Lambda.row(j).tail(n - kNavigation) = Lambda.col(j).tail(n - kNavigation).transpose();
  }
  for (int j = kNavigation; j < n; ++j) {
    const int input_j = s.input[at(j)];
    for (int i = kNavigation; i <= j; ++i) {
      const int input_i = s.input[at(i)];
      double value = s.decay[at(i)] * s.decay[at(j)] * Lambda(i, j);
      if (input_j >= 0) value += s.decay[at(i)] * s.factor[at(j)] * through(i, input_j);
      if (input_i >= 0) value += s.factor[at(i)] * both(j, input_i);
      Lambda(i, j) = Lambda(j, i) = value;
    }
  }
  adjoint(lambda, n, s);
}

void propagate_adjoint(ErrorVector& lambda, const StateLayout& layout, const Transition& t) {
  adjoint(lambda, layout.size(), Structure(layout, t));
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
  for (const Block b : layout.blocks()) {
    if (info(b).process) additive(x, b) *= t.decay[slot(b)];
  }
}

}  // namespace piste
