#include "model/dynamics.h"

#include <array>
#include <span>

#include "math/four.h"
#include "model/imu_error_model.h"
#include "model/three_columns.h"
#include "model/three_rows.h"
#include "piste/math/statistics.h"

namespace piste {
namespace {

constexpr int kRho = full_offset(Block::kPosition);
constexpr int kNu = full_offset(Block::kVelocity);
constexpr int kTheta = full_offset(Block::kAttitude);

std::size_t at(std::ptrdiff_t k) { return static_cast<std::size_t>(k); }
std::size_t slot(Block b) { return at(index_of(b)); }
bool is_scale(Block b) { return b == Block::kGyroScale || b == Block::kAccelScale; }

constexpr int kNavigation = 9;
constexpr int kInputs = 15;  // navigation, e_g and e_a

constexpr std::ptrdiff_t kPadded = kMostStates;
constexpr std::ptrdiff_t kTurnedRows = 12;  // of the navigation, and up to a multiple of four
static_assert(kMostStates % 4 == 0, "a Covariance has room for loops over its columns by four");

// Dependence of the navigation rows on the inputs: position on all but the gyroscopes, velocity on all, attitude on
// itself and the gyroscopes.
constexpr std::array<int, 12> kOfPosition{0, 1, 2, 3, 4, 5, 6, 7, 8, 12, 13, 14};
constexpr std::array<int, 15> kOfVelocity{0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14};
constexpr std::array<int, 6> kOfAttitude{6, 7, 8, 9, 10, 11};

// The contribution of a state to an input.
struct Action {
  int state;
  double factor;
};

// Φ beyond the navigation states: the decay of each state, and how some act on the inputs.
class Slow {
 public:
  std::array<double, kMostStates> decay;
  int first_decaying = 0, end_decaying = 0;   // all others have a decay of 1
  std::array<const double*, kInputs> column;  // of Φ's navigation rows, input by input

  Slow(const StateLayout& layout, const Transition& t) {
    for (const Block b : layout.blocks()) {
      const double f = t.decay[slot(b)];
      const int begin = layout.offset(b), end = begin + info(b).size;
      for (int k = begin; k < end; ++k) decay[at(k)] = f;
      if (f == 1) continue;
      if (end_decaying == 0) first_decaying = begin;
      end_decaying = end;
    }
    for (const ImuErrorBlock& b : kImuErrorBlocks) {
      if (!layout.has(b.block) || (t.imu_scales != nullptr && is_scale(b.block))) continue;
      for (int k = 0; k < b.size(); ++k) {
        const ImuErrorElement& e = b.elements[at(k)];
        const double factor = e.signal == kUnitSignal ? t.bias : signal(e.signal, t.rate, t.force);
        add(e.input, {layout.offset(b.block) + k, factor});
      }
    }
    if (t.imu_scales != nullptr) {
      t.imu_scales->for_each_effect(t.rate, t.force, [&](Block scales, int half, const Matrix3d& effect) {
        if (!layout.has(scales)) return;
        for (int k = 0; k < 9; ++k) add(half + k % 3, {layout.offset(scales) + k / 3, effect(k % 3, k / 3)});
      });
    }
    for (int k = 0; k < kNavigation; ++k) column[at(k)] = t.navigation.col(k).data();
    for (int k = kNavigation; k < kInputs; ++k) column[at(k)] = t.imu.col(k - kNavigation).data();
  }

  /// What acts on e_g and e_a, axis by axis.
  std::span<const Action> acting_on(int imu_input) const {
    return std::span(actions_[at(imu_input)]).first(counts_[at(imu_input)]);
  }

 private:
  void add(int imu_input, Action action) { actions_[at(imu_input)][counts_[at(imu_input)]++] = action; }

  static constexpr std::size_t kMost = 8 + std::size_t{3} * kMostImus;
  std::array<std::array<Action, kMost>, kInputs - kNavigation> actions_;
  std::array<std::size_t, kInputs - kNavigation> counts_{};
};

// The inputs e_g and e_a, from rows of n numbers, a multiple of four, `stride` apart for each state.
PISTE_INSIDE void imu_inputs(const Slow& s, const double* states, std::ptrdiff_t stride, std::ptrdiff_t n,
                             double* out) {
  for (int input = 0; input < kInputs - kNavigation; ++input, out += n) {
    const std::span<const Action> acting = s.acting_on(input);
    if (acting.size() == 3) {  // as it is nearly always: bias, drift and scale
      const double* rows[] = {states + acting[0].state * stride, states + acting[1].state * stride,
                              states + acting[2].state * stride};
      for (std::ptrdiff_t r = 0; r < n; r += 4) {
        Four a, b, c;
        load(rows[0] + r, a);
        load(rows[1] + r, b);
        load(rows[2] + r, c);
        store(acting[0].factor * a + acting[1].factor * b + acting[2].factor * c, out + r);
      }
      continue;
    }
    for (std::ptrdiff_t r = 0; r < n; r += 4) {
      Four sum = {}, a;
      for (const Action& action : acting) {
        load(states + action.state * stride + r, a);
        sum += action.factor * a;
      }
      store(sum, out + r);
    }
  }
}

PISTE_INSIDE void nine_rows(const Slow& s, const double* const* in, std::ptrdiff_t n, double* out) {
  three_rows(s.column.data(), kRho, kOfPosition, in, n, out, n);
  three_rows(s.column.data(), kNu, kOfVelocity, in, n, out, n);
  three_rows(s.column.data(), kTheta, kOfAttitude, in, n, out, n);
}

// Four columns of a matrix of nine rows become four rows of kTurnedRows numbers.
PISTE_INSIDE void turn(const double* rows, std::ptrdiff_t stride, double* out) {
  for (int first = 0; first < kTurnedRows; first += 4) {
    Four r[4];
    for (int i = 0; i < 4; ++i) {
      r[i] = Four{};
      if (first + i < kNavigation) load(rows + (first + i) * stride, r[i]);
    }
    const Four low = __builtin_shufflevector(r[0], r[1], 0, 4, 2, 6),
               high = __builtin_shufflevector(r[0], r[1], 1, 5, 3, 7),
               low2 = __builtin_shufflevector(r[2], r[3], 0, 4, 2, 6),
               high2 = __builtin_shufflevector(r[2], r[3], 1, 5, 3, 7);
    store(__builtin_shufflevector(low, low2, 0, 1, 4, 5), out + first);
    store(__builtin_shufflevector(high, high2, 0, 1, 4, 5), out + kTurnedRows + first);
    store(__builtin_shufflevector(low, low2, 2, 3, 6, 7), out + 2 * kTurnedRows + first);
    store(__builtin_shufflevector(high, high2, 2, 3, 6, 7), out + 3 * kTurnedRows + first);
  }
}

// to = factor × factors × from, number by number.
PISTE_INSIDE void multiply(const double* factors, double factor, const double* from, std::ptrdiff_t begin,
                           std::ptrdiff_t end, double* to) {
  std::ptrdiff_t i = begin;
  for (; i + 4 <= end; i += 4) {
    Four f, x;
    load(factors + i, f);
    load(from + i, x);
    f = factor * f;
    store(f * x, to + i);
  }
  switch (end - i) {  // a loop of three at most would be made wide again
    case 3:
      to[i + 2] = factor * factors[i + 2] * from[i + 2];
      [[fallthrough]];
    case 2:
      to[i + 1] = factor * factors[i + 1] * from[i + 1];
      [[fallthrough]];
    case 1:
      to[i] = factor * factors[i] * from[i];
      break;
    default:
      break;
  }
}

// The nine numbers of the navigation rows: to = factor × from, and to = a + b.
PISTE_INSIDE void multiply_nine(double factor, const double* from, double* to) {
  Four low, high;
  load(from, low);
  load(from + 4, high);
  store(factor * low, to);
  store(factor * high, to + 4);
  to[8] = factor * from[8];
}
PISTE_INSIDE void add_nine(const double* a, const double* b, double* to) {
  Four low, high, low_too, high_too;
  load(a, low);
  load(a + 4, high);
  load(b, low_too);
  load(b + 4, high_too);
  store(low + low_too, to);
  store(high + high_too, to + 4);
  to[8] = a[8] + b[8];
}

// P ← Φ P Φᵀ, and `noise` added to the navigation rows. P has n rows, and room beyond its last column, so that loops
// may go on to a multiple of four.
PISTE_WIDEST void sandwich(double* __restrict P, std::ptrdiff_t n, const Slow& s, const Matrix9d& noise) {
  const std::ptrdiff_t padded = (n + 3) / 4 * 4;
  // Covariance of every error before the step with the inputs, then with the navigation rows after it.
  alignas(32) double imu[(kInputs - kNavigation) * kPadded], after[kNavigation * kPadded];
  imu_inputs(s, P, n, padded, imu);
  const double* in[kInputs];
  for (int k = 0; k < kNavigation; ++k) in[k] = P + k * n;
  for (int k = kNavigation; k < kInputs; ++k) in[k] = imu + (k - kNavigation) * padded;
  nine_rows(s, in, padded, after);

  // The same for the navigation rows themselves.
  alignas(32) double turned[kPadded * kTurnedRows], seen[(kInputs - kNavigation) * kTurnedRows],
      corner[kNavigation * kTurnedRows];
  for (std::ptrdiff_t k = 0; k < padded; k += 4) turn(after + k, padded, turned + k * kTurnedRows);
  imu_inputs(s, turned, kTurnedRows, kTurnedRows, seen);
  for (int k = 0; k < kNavigation; ++k) in[k] = turned + k * kTurnedRows;
  for (int k = kNavigation; k < kInputs; ++k) in[k] = seen + (k - kNavigation) * kTurnedRows;
  nine_rows(s, in, kTurnedRows, corner);

  for (std::ptrdiff_t j = 0; j < kNavigation; ++j) {
    double* column = P + j * n;
    add_nine(corner + j * kTurnedRows, noise.data() + j * kNavigation, column);
    multiply(s.decay.data(), 1, after + j * padded, kNavigation, n, column);
  }
  // The covariance of two navigation errors was computed twice, equal up to rounding: one is kept.
  for (std::ptrdiff_t j = 1; j < kNavigation; ++j) {
    for (std::ptrdiff_t i = 0; i < j; ++i) P[i * n + j] = P[j * n + i];
  }
  for (std::ptrdiff_t j = kNavigation; j < n; ++j) {
    const double d = s.decay[at(j)];
    double* column = P + j * n;
    multiply_nine(d, turned + j * kTurnedRows, column);
    if (d == 1) {
      multiply(s.decay.data(), d, column, s.first_decaying, s.end_decaying, column);
    } else {
      multiply(s.decay.data(), d, column, kNavigation, n, column);
    }
  }
}

// The part of the transition that mend_rate() changes, from `t.step`.
void mend(Transition& t) {
  const ErrorStep& step = t.step;
  t.navigation.setIdentity();
  t.imu.setZero();
  const Vector3d factors = -(1 + step.gyro_scale.array()).inverse();
  const Matrix3d gyro = step.q_wb.toRotationMatrix() * factors.asDiagonal();
  t.imu.block<3, 3>(kTheta, 0) = gyro;
  t.imu.block<3, 3>(kNu, 0) = skew(step.v_wb) * gyro;
  t.bias = 0;
  t.noise.setZero();
}

// The blocks of Φ and of the noise, by `t.step`. R: in the middle of the step.
PISTE_WIDE void fill(Transition& t, const Vector3d& e, const Matrix3d& R) {
  using Three = ThreeColumns;
  const ErrorStep& step = t.step;
  const double dt = step.dt, h = 0.5 * dt * dt;
  const Vector3d& v = step.v_wb;
  const Three V = Three::skew(v), E = Three::skew(e), EE = Three::skews(e, e), VE = Three::skews(v, e);
  const Three gradient = Three::of(step.around.gradient), I = Three::diagonal(1), none = Three::diagonal(0);
  const Three C = Three::skew(step.around.gravity) + VE;  // of ν' by θ
  const auto put = [](auto& matrix, int row, int column, const Three& block) __attribute__((always_inline)) {
    block.put(matrix.data() + column * std::ptrdiff_t{kNavigation} + row, kNavigation);
  };

  // Φ = 1 + A dt + ½ A² dt² for A = (0 1 −V; Γ −2E C; 0 0 −E), block by block.
  put(t.navigation, kRho, kRho, I + h * gradient);
  put(t.navigation, kRho, kNu, dt * I - 2 * h * E);
  put(t.navigation, kRho, kTheta, h * (C + VE) - dt * V);
  put(t.navigation, kNu, kRho, dt * gradient - 2 * h * gradient.turned_by(e));
  put(t.navigation, kNu, kNu, I - 2 * dt * E + h * (gradient + 4 * EE));
  put(t.navigation, kNu, kTheta, dt * C - h * (gradient.times_skew(v) + 2 * C.turned_by(e) + C.times_skew(e)));
  put(t.navigation, kTheta, kRho, none);
  put(t.navigation, kTheta, kNu, none);
  put(t.navigation, kTheta, kTheta, I - dt * E + h * EE);

  // ∫Φ B = (dt + ½ A dt²) B for B = (0 0; V G A; G 0). A rate does not move the position: there V G and −V G cancel.
  const Three turned_back = -1 * Three::of(R);
  const Three gyro = turned_back.times_diagonal((1 + step.gyro_scale.array()).inverse()),
              accel = turned_back.times_diagonal((1 + step.accel_scale.array()).inverse());
  const Three turn = dt * gyro - h * gyro.turned_by(e);
  const Three swing = (dt * V + h * (C - 2 * Three::skews(e, v))) * gyro;
  const Three push = dt * accel - 2 * h * accel.turned_by(e);
  put(t.imu, kRho, 0, none);
  put(t.imu, kRho, 3, h * accel);
  put(t.imu, kNu, 0, swing);
  put(t.imu, kNu, 3, push);
  put(t.imu, kTheta, 0, turn);
  put(t.imu, kTheta, 3, none);

  // ∫ Φ B N Bᵀ Φᵀ over the step, by its value in the middle of the step, where Φ B is nearly ∫Φ B / dt.
  const Vector3d of_gyro = step.around.noise.gyro / dt, of_accel = step.around.noise.accel / dt;
  const Three swung = swing.times_diagonal(of_gyro), pushed = push.times_diagonal(of_accel);
  const Three moved = h * pushed.times_transposed(accel), swung_turn = swung.times_transposed(turn);
  put(t.noise, kRho, kRho, h * h * accel.times_diagonal(of_accel).times_transposed(accel));
  put(t.noise, kRho, kNu, moved.transposed());
  put(t.noise, kRho, kTheta, none);
  put(t.noise, kNu, kRho, moved);
  put(t.noise, kNu, kNu, swung.times_transposed(swing) + pushed.times_transposed(push));
  put(t.noise, kNu, kTheta, swung_turn);
  put(t.noise, kTheta, kRho, none);
  put(t.noise, kTheta, kNu, swung_turn.transposed());
  put(t.noise, kTheta, kTheta, turn.times_diagonal(of_gyro).times_transposed(turn));
}

// All but the processes, by `t.step`.
void complete(Transition& t, const Vector3d& earth_rate) {
  t.rate = t.step.rate;
  t.force = t.step.force;
  t.decay.fill(1);
  t.variance.fill(Vector3d::Zero());
  if (t.step.dt == 0) {
    mend(t);
  } else {
    fill(t, earth_rate, t.step.q_wb.toRotationMatrix());
  }
}

}  // namespace

Transition linearize(const Estimate& x, const Estimate& end, const ImuStep& s, const Vector3d& earth_rate,
                     const Gravity& gravity, const StepNoise& noise, const Vector3d* standing) {
  Transition t;
  ErrorStep& step = t.step;  // in its place, as copies cost as much as the rest
  step.dt = s.dt;
  step.q_wb = x.q_wb * so3_exp(0.5 * s.dtheta);
  // At rest the measured rate is noise alone, and would give false information on the scale.
  if (standing) {
    step.v_wb.setZero();
    step.rate.setZero();
    step.force = *standing;
  } else {
    step.v_wb = 0.5 * (x.v_wb + end.v_wb);
    step.rate = s.mean_rate();
    step.force = s.mean_force();
  }
  step.gyro_scale = x.gyro_scale;
  step.accel_scale = x.accel_scale;
  step.around.gravity = gravity.value;
  step.around.gradient = gravity.gradient;
  step.around.noise.gyro = noise.gyro;
  step.around.noise.accel = noise.accel;
  complete(t, earth_rate);
  return t;
}

Transition linearize(const ErrorStep& step, const Vector3d& earth_rate) {
  Transition t;
  t.step = step;
  complete(t, earth_rate);
  return t;
}

Transition mend_rate(const Estimate& x, const Vector3d& noise_angle) {
  return linearize({.dt = 0,
                    .q_wb = x.q_wb,
                    .v_wb = x.v_wb,
                    .rate = x.R_wb().transpose() * noise_angle,
                    .force = Vector3d::Zero(),
                    .gyro_scale = x.gyro_scale,
                    .accel_scale = x.accel_scale,
                    .around = {Vector3d::Zero(), Matrix3d::Zero(), {Vector3d::Zero(), Vector3d::Zero()}}},
                   Vector3d::Zero());
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
  for (int k = 0; k < kInputs - kNavigation; ++k) {
    for (const Action& action : s.acting_on(k)) inputs(kNavigation + k) += action.factor * m(action.state);
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
  for (int k = 0; k < kInputs - kNavigation; ++k) {
    for (const Action& action : s.acting_on(k)) Phi.col(action.state).head<9>() += action.factor * t.imu.col(k);
  }
  return Phi;
}

void decay(Estimate& x, const StateLayout& layout, const Transition& t) {
  for (const Block b : layout.blocks()) {
    if (info(b).process) additive(x, b) *= t.decay[slot(b)];
  }
}

}  // namespace piste
