#include "model/step_operator.h"

#include <algorithm>
#include <utility>

#include "math/four.h"
#include "model/imu_error_model.h"

namespace piste {
namespace {

using State = StepOperator::State;

std::size_t place(int k) { return static_cast<std::size_t>(k); }

struct Triple {
  Four x, y, z;
};

PISTE_INSIDE Triple operator+(const Triple& a, const Triple& b) { return {a.x + b.x, a.y + b.y, a.z + b.z}; }
PISTE_INSIDE Triple operator*(double f, const Triple& a) { return {f * a.x, f * a.y, f * a.z}; }
// v × a
PISTE_INSIDE Triple cross(const Vector3d& v, const Triple& a) {
  return {v.y() * a.z - v.z() * a.y, v.z() * a.x - v.x() * a.z, v.x() * a.y - v.y() * a.x};
}
// Mᵀ a
PISTE_INSIDE Triple transposed(const Matrix3d& M, const Triple& a) {
  const double* m = M.data();
  return {m[0] * a.x + m[1] * a.y + m[2] * a.z, m[3] * a.x + m[4] * a.y + m[5] * a.z,
          m[6] * a.x + m[7] * a.y + m[8] * a.z};
}

// Aᵀ (ρ, ν, θ)
struct Navigation9 {
  Triple rho, nu, theta;
};
PISTE_INSIDE Navigation9 transposed_rate(const StepOperator::Factors& f, const Vector3d& earth_rate,
                                         const Navigation9& x) {
  return {transposed(f.gradient, x.nu), x.rho + 2 * cross(earth_rate, x.nu),
          cross(f.v, x.rho) + transposed(f.C, x.nu) + cross(earth_rate, x.theta)};
}

// N times four lanes; λ is in lane `lambda`.
template <int N>
PISTE_INSIDE void adjoint_of(const StepOperator::Factors& f, const Vector3d& earth_rate, int n, const State* states,
                             const std::vector<StepOperator::Across>& across, int lambda, double* M,
                             StepOperator::Pull& pull) {
  constexpr std::ptrdiff_t kFour = 4, kStride = kFour * N;
  Four seen[6][N];
  for (int i = 0; i < N; ++i) {
    const auto triple = [&](int k) -> Triple {
      double* p = M + k * kStride + kFour * i;
      Triple three;
      load(p, three.x);
      load(p + kStride, three.y);
      load(p + 2 * kStride, three.z);
      return three;
    };
    const Navigation9 x{triple(0), triple(3), triple(6)};
    const Navigation9 once = transposed_rate(f, earth_rate, x), twice = transposed_rate(f, earth_rate, once);
    const auto put = [&](int k, const Triple& a, const Triple& b, const Triple& c) {
      const Triple sum = a + f.first * b + f.second * c;
      double* p = M + k * kStride + kFour * i;
      store(sum.x, p);
      store(sum.y, p + kStride);
      store(sum.z, p + 2 * kStride);
    };
    put(0, x.rho, once.rho, twice.rho);
    put(3, x.nu, once.nu, twice.nu);
    put(6, x.theta, once.theta, twice.theta);
    // Bᵀ (dt + ½ Aᵀ dt²)
    const Triple nu = f.input * x.nu + f.second * once.nu, theta = f.input * x.theta + f.second * once.theta;
    const Triple gyro = transposed(f.R, theta + cross(-f.v, nu)), accel = transposed(f.R, nu);
    const Four* parts[] = {&gyro.x, &gyro.y, &gyro.z, &accel.x, &accel.y, &accel.z};
    for (int k = 0; k < 6; ++k) seen[k][i] = f.of_imu[k / 3](k % 3) * *parts[k];
  }
  for (int k = 0; k < 6; ++k) pull[place(k)] = f.noise[k / 3](k % 3) * seen[k][lambda / 4][lambda % 4];
  for (int k = StepOperator::kNavigation; k < n; ++k) {
    const State& s = states[k];
    double* row = M + k * kStride;
    if (s.process >= 0) pull[place(6 + k)] = f.variance[place(s.process)] * s.weight * row[lambda];
    const double decay = s.process < 0 ? 1 : f.decay[place(s.process)];
    const double acts = s.input < 0 ? 0 : f.acts[place(s.acts)];
    const Four* through = seen[std::max(0, s.input)];
    for (int i = 0; i < N; ++i) {
      Four four;
      load(row + kFour * i, four);
      store(decay * four + acts * through[i], row + kFour * i);
    }
  }
  for (std::size_t j = 0; j < across.size(); ++j) {
    double* row = M + across[j].state * kStride;
    for (int i = 0; i < N; ++i) {
      Four four;
      load(row + kFour * i, four);
      store(four + f.across[j] * seen[across[j].input][i], row + kFour * i);
    }
  }
}

PISTE_WIDE void adjoint_all(const StepOperator::Factors& f, const Vector3d& earth_rate, int n, const State* states,
                            const std::vector<StepOperator::Across>& across, double* M, StepOperator::Pull& pull) {
  adjoint_of<StepOperator::kLanes / 4>(f, earth_rate, n, states, across, StepOperator::kLambda, M, pull);
}
PISTE_WIDE void adjoint_one(const StepOperator::Factors& f, const Vector3d& earth_rate, int n, const State* states,
                            const std::vector<StepOperator::Across>& across, double* M, StepOperator::Pull& pull) {
  adjoint_of<1>(f, earth_rate, n, states, across, 0, M, pull);
}

}  // namespace

StepOperator::StepOperator(const StateLayout& layout, const FilterOptions& options, Vector3d earth_rate)
    : layout_(layout),
      options_(options),
      earth_rate_(std::move(earth_rate)),
      n_(layout.size()),
      imu_scales_(ImuScales::across(options)) {
  for (const ImuErrorBlock& b : kImuErrorBlocks) {
    const bool across = imu_scales_ && (b.block == Block::kGyroScale || b.block == Block::kAccelScale);
    if (!layout.has(b.block) || across) continue;
    for (int k = 0; k < b.size(); ++k) {
      State& s = states_[place(layout.offset(b.block) + k)];
      s.input = b.elements[place(k)].input;
      s.acts = b.elements[place(k)].signal;
    }
  }
  if (imu_scales_) {
    const Vector3d none = Vector3d::Zero();
    imu_scales_->for_each_effect(none, none, [&](Block scales, int half, const Matrix3d&) {
      for (int k = 0; k < 9 && layout.has(scales); ++k)
        across_.push_back({layout.offset(scales) + k / 3, half + k % 3});
    });
  }
  for (const Block b : layout.blocks()) {
    const std::optional<BlockProcess> process = info(b).process ? info(b).process(options) : std::nullopt;
    if (!process) continue;
    for (int k = 0; k < info(b).size; ++k) {
      State& s = states_[place(layout.offset(b) + k)];
      s.process = static_cast<int>(processes_.size());
      s.weight = process->weight(k);
    }
    processes_.push_back(process->law);
  }
}

void StepOperator::load(const ErrorStep& step, Factors& f) const {
  const bool mends = step.dt == 0;
  f.first = step.dt;
  f.second = 0.5 * step.dt * step.dt;
  f.input = mends ? 1 : step.dt;
  f.R = step.q_wb.toRotationMatrix();
  f.v = step.v_wb;
  f.gradient = step.around.gradient;
  f.C = skew(step.around.gravity) + skew(step.v_wb) * skew(earth_rate_);
  f.of_imu[0] = -(1 + step.gyro_scale.array()).inverse();
  f.of_imu[1] = -(1 + step.accel_scale.array()).inverse();
  f.noise[0] = mends ? Vector3d::Zero().eval() : (step.around.noise.gyro / step.dt).eval();
  f.noise[1] = mends ? Vector3d::Zero().eval() : (step.around.noise.accel / step.dt).eval();
  for (int k = 0; k < kUnitSignal; ++k) f.acts[place(k)] = signal(k, step.rate, step.force);
  f.acts[place(kUnitSignal)] = mends ? 0 : 1;
  if (imu_scales_) {
    f.across.clear();
    imu_scales_->for_each_effect(step.rate, step.force, [&](Block scales, int, const Matrix3d& effect) {
      if (layout_.has(scales)) f.across.insert(f.across.end(), effect.data(), effect.data() + effect.size());
    });
  }
  for (std::size_t i = 0; i < processes_.size(); ++i) {
    const DiscreteProcess d = mends ? DiscreteProcess{1, 0} : discretise(processes_[i], step.dt);
    f.decay[i] = d.transition;
    f.variance[i] = d.variance;
  }
}

Transition StepOperator::transition(const ErrorStep& step) const {
  Transition t = linearize(step, earth_rate_);
  t.imu_scales = imu_scales_.get();
  if (step.dt > 0) add_processes(t, layout_, options_, step.dt);
  return t;
}

void StepOperator::adjoint(const Factors& f, Lanes& M, Pull& pull) const {
  adjoint_all(f, earth_rate_, n_, states_.data(), across_, M.data(), pull);
}

void StepOperator::adjoint_lambda(const Factors& f, Lanes& M, Pull& pull) const {
  adjoint_one(f, earth_rate_, n_, states_.data(), across_, M.data(), pull);
}

void StepOperator::forward(const Factors& f, ErrorVector& e, const Pull* pull) const {
  Vector3d imu[2] = {Vector3d::Zero(), Vector3d::Zero()};
  for (int k = kNavigation; k < n_; ++k) {
    const State& s = states_[place(k)];
    if (s.input >= 0) imu[s.input / 3](s.input % 3) += f.acts[place(s.acts)] * e(k);
    if (s.process < 0) continue;
    e(k) *= f.decay[place(s.process)];
    if (pull != nullptr) e(k) -= (*pull)[place(6 + k)];
  }
  for (std::size_t j = 0; j < across_.size(); ++j) {
    imu[across_[j].input / 3](across_[j].input % 3) += f.across[j] * e(across_[j].state);
  }
  if (pull != nullptr) {
    for (int k = 0; k < 6; ++k) imu[k / 3](k % 3) -= (*pull)[place(k)];
  }
  struct Three {
    Vector3d rho, nu, theta;
  };
  const auto rate_of = [&](const Three& x) -> Three {  // A x
    return {x.nu - f.v.cross(x.theta), f.gradient * x.rho - 2 * earth_rate_.cross(x.nu) + f.C * x.theta,
            -earth_rate_.cross(x.theta)};
  };
  const Three x{e.segment<3>(0), e.segment<3>(3), e.segment<3>(6)};
  const Vector3d turned = f.R * f.of_imu[0].cwiseProduct(imu[0]);  // B of the IMU's errors
  const Vector3d pushed = f.R * f.of_imu[1].cwiseProduct(imu[1]) + f.v.cross(turned);
  const Three once = rate_of(x), twice = rate_of({once.rho, once.nu + pushed, once.theta + turned});
  e.segment<3>(0) = x.rho + f.first * once.rho + f.second * twice.rho;
  e.segment<3>(3) = x.nu + f.first * once.nu + f.input * pushed + f.second * twice.nu;
  e.segment<3>(6) = x.theta + f.first * once.theta + f.input * turned + f.second * twice.theta;
}

}  // namespace piste
