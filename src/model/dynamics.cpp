#include "piste/model/dynamics.h"

#include <algorithm>
#include <iterator>

#include "math/wide.h"
#include "model/three_rows.h"
#include "piste/math/statistics.h"

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

std::size_t at(int k) { return static_cast<std::size_t>(k); }
std::size_t slot(Block b) { return at(index_of(b)); }

constexpr int kNavigation = 9;
constexpr int kInputs = 15;  // navigation, e_g and e_a

constexpr int kPadded = (kMostStates + 3) / 4 * 4;
constexpr std::ptrdiff_t kStorage = std::ptrdiff_t{kMostStates} * kMostStates;  // values in a Covariance
static_assert(kStorage >= kNavigation * kMostStates + 4);  // what loops over padded columns may read

// What the navigation rows depend on among the inputs: position on all but the gyroscopes, velocity on all, attitude on
// itself and the gyroscopes.
constexpr std::array<int, 12> kOfPosition{0, 1, 2, 3, 4, 5, 6, 7, 8, 12, 13, 14};
constexpr std::array<int, 15> kOfVelocity{0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14};
constexpr std::array<int, 6> kOfAttitude{6, 7, 8, 9, 10, 11};

// What a state adds to an input (e_g, e_a).
struct Action {
  int state, input;
  double factor;
};

// Φ beyond the navigation states: the decay of each state, and how some act on the inputs.
struct Slow {
  std::array<Action, std::size_t{3} * 4 + std::size_t{9} * 2 * kMostUnits> actions;
  std::size_t count = 0;
  std::array<double, kMostStates> decay;
  std::array<const double*, kInputs> column;  // of Φ's navigation rows, input by input

  Slow(const StateLayout& layout, const Transition& t) {
    for (const Block b : layout.blocks()) {
      const double f = t.decay[slot(b)];
      for (int k = layout.offset(b); k < layout.offset(b) + info(b).size; ++k) decay[at(k)] = f;
    }
    for (const ImuBlock& b : kImuBlocks) {
      if (!layout.has(b.block) || (b.scale && t.units != nullptr)) continue;
      const Vector3d factors = !b.scale ? Vector3d::Constant(t.bias) : b.half == 0 ? t.rate : t.force;
      for (int k = 0; k < 3; ++k) actions[count++] = {layout.offset(b.block) + k, b.half + k, factors(k)};
    }
    if (t.units != nullptr) {
      t.units->for_each_effect(t.rate, t.force, [&](Block scales, int half, const Matrix3d& effect) {
        if (!layout.has(scales)) return;
        for (int k = 0; k < 9; ++k) {
          actions[count++] = {layout.offset(scales) + k / 3, half + k % 3, effect(k % 3, k / 3)};
        }
      });
    }
    for (int k = 0; k < kNavigation; ++k) column[at(k)] = t.navigation.col(k).data();
    for (int k = kNavigation; k < kInputs; ++k) column[at(k)] = t.imu.col(k - kNavigation).data();
  }
};

[[gnu::always_inline]] inline void nine_rows(const Slow& s, const double* const* in, std::ptrdiff_t n,
                                             double (*out)[kPadded]) {
  three_rows(s.column.data(), kRho, kOfPosition, in, n, out);
  three_rows(s.column.data(), kNu, kOfVelocity, in, n, out);
  three_rows(s.column.data(), kTheta, kOfAttitude, in, n, out);
}

// P ← Φ P Φᵀ, and `noise` added to the navigation rows. P has n rows, and room beyond its last column, so that loops
// may go on to a multiple of four.
PISTE_WIDE void sandwich(double* __restrict P, std::ptrdiff_t n, const Slow& s, const Matrix9d& noise) {
  const std::ptrdiff_t padded = (n + 3) / 4 * 4;
  // Covariance of every error before the step with the inputs, then with the navigation rows after it.
  alignas(32) double imu[kInputs - kNavigation][kPadded];
  for (auto& column : imu) {
    for (std::ptrdiff_t r = 0; r < padded; ++r) column[r] = 0;
  }
  for (std::size_t i = 0; i < s.count; ++i) {
    const auto [state, input, f] = s.actions[i];
    double* __restrict to = imu[input];
    const double* column = P + state * n;
    const std::ptrdiff_t rows = std::min(padded, kStorage - state * n);
    for (std::ptrdiff_t r = 0; r < rows; ++r) to[r] += f * column[r];
  }
  const double* in[kInputs];
  for (int k = 0; k < kNavigation; ++k) in[k] = P + k * n;
  for (int k = kNavigation; k < kInputs; ++k) in[k] = imu[k - kNavigation];
  alignas(32) double after[kNavigation][kPadded];
  nine_rows(s, in, padded, after);

  // The same for the navigation rows themselves.
  constexpr int kRows = 12;  // nine, and up to a multiple of four
  alignas(32) double turned[kInputs][kRows] = {};
  for (int k = 0; k < kNavigation; ++k) {
    for (int i = 0; i < kNavigation; ++i) turned[k][i] = after[i][k];
  }
  for (std::size_t i = 0; i < s.count; ++i) {
    const auto [state, input, f] = s.actions[i];
    double* __restrict to = turned[kNavigation + input];
    for (int r = 0; r < kNavigation; ++r) to[r] += f * after[r][state];
  }
  for (int k = 0; k < kInputs; ++k) in[k] = turned[k];
  alignas(32) double corner[kNavigation][kPadded];
  nine_rows(s, in, kRows, corner);

  // The covariance of two navigation errors comes out twice, equal but for rounding: one is kept.
  const double* added = noise.data();
  for (int j = 0; j < kNavigation; ++j) {
    double column[kNavigation];
    for (int i = 0; i < kNavigation; ++i) column[i] = corner[j][i] + added[j * kNavigation + i];
    for (int i = 0; i <= j; ++i) P[j * n + i] = column[i];
    for (int i = 0; i < j; ++i) P[i * n + j] = column[i];
    for (int i = kNavigation; i < n; ++i) P[j * n + i] = s.decay[at(i)] * after[j][i];
  }
  for (int j = kNavigation; j < n; ++j) {
    const double d = s.decay[at(j)];
    double* column = P + j * n;
    for (int i = 0; i < kNavigation; ++i) column[i] = d * after[i][j];
    for (int i = kNavigation; i < n; ++i) column[i] *= d * s.decay[at(i)];
  }
}

}  // namespace

Transition linearize(const Estimate& x, const Estimate& end, const ImuStep& s, const Vector3d& earth_rate,
                     const Gravity& gravity, const StepNoise& noise, const Vector3d* standing) {
  // At rest the measured rate is noise alone, and would give false information on the scale.
  return linearize({.dt = s.dt,
                    .q_wb = x.q_wb * so3_exp(0.5 * s.dtheta),
                    .v_wb = standing ? Vector3d::Zero().eval() : (0.5 * (x.v_wb + end.v_wb)).eval(),
                    .rate = standing ? Vector3d::Zero().eval() : s.mean_rate(),
                    .force = standing ? *standing : s.mean_force(),
                    .gyro_scale = x.gyro_scale,
                    .accel_scale = x.accel_scale,
                    .around = {gravity.value, gravity.gradient, noise}},
                   earth_rate);
}

namespace {

// [a×] M, M [a×], [a×] [b×]: a third less to compute than products of matrices.
Matrix3d skew_times(const Vector3d& a, const Matrix3d& M) {
  Matrix3d out;
  for (int k = 0; k < 3; ++k) out.col(k) = a.cross(M.col(k));
  return out;
}
Matrix3d times_skew(const Matrix3d& M, const Vector3d& a) {
  Matrix3d out;
  out.col(0) = a.z() * M.col(1) - a.y() * M.col(2);
  out.col(1) = a.x() * M.col(2) - a.z() * M.col(0);
  out.col(2) = a.y() * M.col(0) - a.x() * M.col(1);
  return out;
}
Matrix3d product_of_skews(const Vector3d& a, const Vector3d& b) {
  Matrix3d out = b * a.transpose();
  out.diagonal().array() -= a.dot(b);
  return out;
}

// −R (1 + s)⁻¹: how an error of the IMU turns the attitude, or changes the velocity.
Matrix3d effect_of(const Matrix3d& R, const Vector3d& scale) {
  return -R * (1 + scale.array()).inverse().matrix().asDiagonal();
}

// What mend_rate() changes.
Transition mended(const ErrorStep& step) {
  Transition t;
  t.navigation.setIdentity();
  t.imu.setZero();
  const Matrix3d gyro = effect_of(step.q_wb.toRotationMatrix(), step.gyro_scale);
  t.imu.block<3, 3>(kTheta, 0) = gyro;
  t.imu.block<3, 3>(kNu, 0) = skew(step.v_wb) * gyro;
  t.rate = step.rate;
  t.force = step.force;
  t.bias = 0;
  t.noise.setZero();
  t.decay.fill(1);
  t.variance.fill(Vector3d::Zero());
  t.step = step;
  return t;
}

}  // namespace

Transition linearize(const ErrorStep& step, const Vector3d& earth_rate) {
  if (step.dt == 0) return mended(step);
  Transition t;
  t.step = step;
  t.rate = step.rate;
  t.force = step.force;
  t.decay.fill(1);
  t.variance.fill(Vector3d::Zero());

  const double dt = step.dt;
  const Matrix3d R_mid = step.q_wb.toRotationMatrix();
  const Vector3d& e = earth_rate;
  const Matrix3d V = skew(step.v_wb), E = skew(e);
  const Matrix3d VE = product_of_skews(step.v_wb, e), EV = product_of_skews(e, step.v_wb), EE = product_of_skews(e, e);
  const Matrix3d& gradient = step.around.gradient;
  const Matrix3d C = skew(step.around.gravity) + VE;  // of ν' by θ

  // Φ = 1 + A dt + ½ A² dt² for A = (0 1 −V; Γ −2E C; 0 0 −E), block by block.
  const double h = 0.5 * dt * dt;
  const Matrix3d I = Matrix3d::Identity();
  const Matrix3d of_velocity = dt * I - 2 * h * E;
  t.navigation.block<3, 3>(kRho, kRho) = I + h * gradient;
  t.navigation.block<3, 3>(kRho, kNu) = of_velocity;
  t.navigation.block<3, 3>(kRho, kTheta) = -dt * V + h * (C + VE);
  t.navigation.block<3, 3>(kNu, kRho) = dt * gradient - 2 * h * skew_times(e, gradient);
  t.navigation.block<3, 3>(kNu, kNu) = I - 2 * dt * E + h * (gradient + 4 * EE);
  t.navigation.block<3, 3>(kNu, kTheta) =
      dt * C - h * (times_skew(gradient, step.v_wb) + 2 * skew_times(e, C) + times_skew(C, e));
  t.navigation.block<3, 3>(kTheta, kRho).setZero();
  t.navigation.block<3, 3>(kTheta, kNu).setZero();
  t.navigation.block<3, 3>(kTheta, kTheta) = I - dt * E + h * EE;

  // ∫Φ B = (dt + ½ A dt²) B for B = (0 0; V G A; G 0). A rate does not move the position: there V G and −V G cancel.
  const Matrix3d gyro = effect_of(R_mid, step.gyro_scale), accel = effect_of(R_mid, step.accel_scale);
  const Matrix3d turn = dt * gyro - h * skew_times(e, gyro);
  const Matrix3d swing = (dt * V + h * (C - 2 * EV)).lazyProduct(gyro);
  const Matrix3d push = dt * accel - 2 * h * skew_times(e, accel);
  t.imu.block<3, 3>(kRho, 0).setZero();
  t.imu.block<3, 3>(kRho, 3) = h * accel;
  t.imu.block<3, 3>(kNu, 0) = swing;
  t.imu.block<3, 3>(kNu, 3) = push;
  t.imu.block<3, 3>(kTheta, 0) = turn;
  t.imu.block<3, 3>(kTheta, 3).setZero();

  // ∫ Φ B N Bᵀ Φᵀ over the step, by its value in the middle of the step, where Φ B is nearly ∫Φ B / dt.
  const StepNoise& noise = step.around.noise;
  const Matrix3d turned = turn * (noise.gyro / dt).asDiagonal(), swung = swing * (noise.gyro / dt).asDiagonal();
  const Matrix3d pushed = push * (noise.accel / dt).asDiagonal();
  const Matrix3d moved = pushed.lazyProduct(accel.transpose());
  t.noise.block<3, 3>(kRho, kRho) = square(h) * accel * (noise.accel / dt).asDiagonal() * accel.transpose();
  t.noise.block<3, 3>(kRho, kNu) = h * moved.transpose();
  t.noise.block<3, 3>(kRho, kTheta).setZero();
  t.noise.block<3, 3>(kNu, kRho) = h * moved;
  t.noise.block<3, 3>(kNu, kNu) = swung.lazyProduct(swing.transpose()) + pushed.lazyProduct(push.transpose());
  t.noise.block<3, 3>(kNu, kTheta) = swung.lazyProduct(turn.transpose());
  t.noise.block<3, 3>(kTheta, kRho).setZero();
  t.noise.block<3, 3>(kTheta, kNu) = t.noise.block<3, 3>(kNu, kTheta).transpose();
  t.noise.block<3, 3>(kTheta, kTheta) = turned.lazyProduct(turn.transpose());
  return t;
}

Transition mend_rate(const Estimate& x, const Vector3d& noise_angle) {
  return mended({.dt = 0,
                 .q_wb = x.q_wb,
                 .v_wb = x.v_wb,
                 .rate = x.R_wb().transpose() * noise_angle,
                 .force = Vector3d::Zero(),
                 .gyro_scale = x.gyro_scale,
                 .accel_scale = x.accel_scale,
                 .around = {Vector3d::Zero(), Matrix3d::Zero(), {Vector3d::Zero(), Vector3d::Zero()}}});
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
  const Slow s(layout, t);
  sandwich(P.data(), layout.size(), s, t.noise);
  for (const Block b : layout.blocks()) {
    const int size = info(b).size;
    P.diagonal().segment(layout.offset(b), size) += t.variance[slot(b)].head(size);
  }
}

void propagate(ErrorVector& m, const StateLayout& layout, const Transition& t) {
  const Slow s(layout, t);
  Eigen::Matrix<double, kNavigation, kInputs> mixer;
  mixer << t.navigation, t.imu;
  Eigen::Matrix<double, kInputs, 1> inputs = Eigen::Matrix<double, kInputs, 1>::Zero();
  inputs.head<kNavigation>() = m.head<kNavigation>();
  for (std::size_t i = 0; i < s.count; ++i) {
    inputs(kNavigation + s.actions[i].input) += s.actions[i].factor * m(s.actions[i].state);
  }
  for (int k = kNavigation; k < layout.size(); ++k) m(k) *= s.decay[at(k)];
  m.head<kNavigation>() = mixer.lazyProduct(inputs);
}

Covariance dense_transition(const StateLayout& layout, const Transition& t) {
  const Slow s(layout, t);
  Covariance Phi = Covariance::Identity(layout.size(), layout.size());
  for (const Block b : layout.blocks()) {
    Phi.diagonal().segment(layout.offset(b), info(b).size) *= t.decay[slot(b)];
  }
  Phi.topLeftCorner<9, 9>() = t.navigation;
  for (std::size_t i = 0; i < s.count; ++i) {
    const auto [state, input, factor] = s.actions[i];
    Phi.col(state).head<9>() += factor * t.imu.col(input);
  }
  return Phi;
}

void decay(Estimate& x, const StateLayout& layout, const Transition& t) {
  for (const Block b : layout.blocks()) {
    if (info(b).process) additive(x, b) *= t.decay[slot(b)];
  }
}

}  // namespace piste
