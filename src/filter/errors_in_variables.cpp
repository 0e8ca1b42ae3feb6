#include "filter/errors_in_variables.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <utility>

#include "math/square.h"
#include "math/wide.h"
#include "model/imu_errors.h"
#include "piste/math/statistics.h"

namespace piste {
namespace {

constexpr std::array kScales{Block::kGyroScale, Block::kAccelScale};
constexpr int kVelocity = 3, kAttitude = 6;  // among the errors of navigation
constexpr double kNegligible = 1e-4;  // of a fix's variance: a smaller part of the noise in it is left out at rest

constexpr std::size_t place(std::ptrdiff_t k) { return static_cast<std::size_t>(k); }

// out += weight in, for the numbers of some elements with their lanes.
PISTE_INSIDE void add_to(double* __restrict out, const double* __restrict in, std::ptrdiff_t count, double weight) {
  for (std::ptrdiff_t i = 0; i < count; ++i) out[i] += weight * in[i];
}

// An element of a matrix other than the identity, row by row.
struct Element {
  std::ptrdiff_t row, column;
  double value;
};

// X ← A X for rows of `width` numbers, and an A without elements below its diagonal.
PISTE_INSIDE void multiply(const Element* begin, const Element* end, std::ptrdiff_t width, double* __restrict X) {
  for (const Element* e = begin; e != end; ++e) {
    double* __restrict x = X + e->row * width;
    if (e->row == e->column) {
      for (std::ptrdiff_t i = 0; i < width; ++i) x[i] *= e->value;
    } else {
      add_to(x, X + e->column * width, width, e->value);
    }
  }
}

// X ← A X Aᵀ for a row-major X of n × n elements with their lanes.
PISTE_WIDEST void propagate_moments(const Element* begin, const Element* end, std::ptrdiff_t n, std::ptrdiff_t lanes,
                                    double* __restrict X) {
  const std::ptrdiff_t row = n * lanes;
  multiply(begin, end, row, X);
  for (double* x = X; x != X + n * row; x += row) multiply(begin, end, lanes, x);
}

// X ← (I − K H) X (I − K H)ᵀ, and trace += tr(S⁻¹ H X Hᵀ) of the X before it. K: n × 3 and H: 3 × n, `seen` the columns
// of H that are not zero.
PISTE_WIDEST void observe_moments(const double* K, const double* H, const double* S_inverse, const std::ptrdiff_t* seen,
                                  std::ptrdiff_t count, std::ptrdiff_t n, std::ptrdiff_t lanes, double* __restrict X,
                                  double* __restrict work, double* __restrict trace) {
  const std::ptrdiff_t row = n * lanes;
  std::fill(work, work + 3 * row, 0.0);
  for (std::ptrdiff_t r = 0; r < 3; ++r) {  // H X
    for (std::ptrdiff_t i = 0; i < count; ++i) add_to(work + r * row, X + seen[i] * row, row, H[3 * seen[i] + r]);
  }
  for (std::ptrdiff_t r = 0; r < 3; ++r) {
    for (std::ptrdiff_t s = 0; s < 3; ++s) {
      for (std::ptrdiff_t i = 0; i < count; ++i)
        add_to(trace, work + r * row + seen[i] * lanes, lanes, S_inverse[3 * s + r] * H[3 * seen[i] + s]);
    }
  }
  for (std::ptrdiff_t a = 0; a < n; ++a) {
    for (std::ptrdiff_t r = 0; r < 3; ++r) add_to(X + a * row, work + r * row, row, -K[r * n + a]);
  }
  for (std::ptrdiff_t a = 0; a < n; ++a) {
    double* x = X + a * row;
    std::fill(work, work + 3 * lanes, 0.0);
    for (std::ptrdiff_t r = 0; r < 3; ++r) {  // X Hᵀ
      for (std::ptrdiff_t i = 0; i < count; ++i)
        add_to(work + r * lanes, x + seen[i] * lanes, lanes, H[3 * seen[i] + r]);
    }
    for (std::ptrdiff_t b = 0; b < n; ++b) {
      for (std::ptrdiff_t r = 0; r < 3; ++r) add_to(x + b * lanes, work + r * lanes, lanes, -K[r * n + b]);
    }
  }
}

}  // namespace

ErrorsInVariables::ErrorsInVariables(const FilterOptions& options, const StateLayout& layout) {
  gyro_ = square(options.sensor.gyro.noise);
  accel_ = square(options.sensor.accel.noise);
  of_gyro_ = gyro_ > 0 && options.estimates(Block::kGyroScale) && options.attitude.empty();
  of_accel_ = accel_ > 0 && options.estimates(Block::kAccelScale);
  for (int k = 0; k < kNavigation; ++k) states_[place(k)] = k;
  for (const Block b : layout.blocks()) {
    // The differences of several IMUs have no part in the motion.
    if (info(b).process == nullptr || index_of(b) >= index_of(Block::kFirstParity)) continue;
    const std::optional<BlockProcess> process = info(b).process(options);
    if (!process || size_ + info(b).size > kMost) continue;
    if (b == Block::kGyroDrift) gyro_drift_ = size_;
    if (b == Block::kAccelDrift) accel_drift_ = size_;
    for (int k = 0; k < info(b).size; ++k) {
      if (!(process->weight(k) > 0)) continue;
      states_[place(size_)] = layout.offset(b) + k;
      laws_[place(size_++)] = process->law;
    }
  }
}

bool ErrorsInVariables::counts(int drift) const { return drift > 0 && lasted_ > laws_[place(drift)].correlation_time; }

// The covariance of position, velocity (its ordinary error), attitude and processes, for given constants: a tilt that a
// bias explains is not one that noise has turned.
ErrorsInVariables::Square ErrorsInVariables::for_given_constants(const Estimate& x, const Covariance& P) const {
  // Schur's complement, by elimination of the constants, which come first. Only the lower half is there.
  std::array<bool, kMostStates> changes{};
  for (int k = 0; k < size_; ++k) changes[place(states_[place(k)])] = true;
  std::array<int, kMostStates> order;
  int count = 0;
  for (int k = 0; k < static_cast<int>(P.rows()); ++k) {
    if (!changes[place(k)]) order[place(count++)] = k;
  }
  std::copy_n(states_.begin(), size_, order.begin() + count);
  Covariance C(P.rows(), P.rows());
  for (int j = 0; j < static_cast<int>(P.rows()); ++j) {
    for (int i = j; i < static_cast<int>(P.rows()); ++i) C(i, j) = P(order[place(i)], order[place(j)]);
  }
  eliminate_first(C.data(), P.rows(), count);
  piste::Square all = C.bottomRightCorner(size_, size_).selfadjointView<Eigen::Lower>();
  const Matrix3d T = ordinary_from_invariant(x).block<3, 3>(kVelocity, kAttitude);
  for (const int drift : {gyro_drift_, accel_drift_}) {
    if (drift > 0 && !counts(drift)) hold(all, drift);
  }
  all.middleRows<3>(kVelocity) += T.lazyProduct(all.middleRows<3>(kAttitude)).eval();
  all.middleCols<3>(kVelocity) += all.middleCols<3>(kAttitude).lazyProduct(T.transpose()).eval();
  return all;
}

// Over a time with a mean specific force in the world frame.
ErrorsInVariables::Square ErrorsInVariables::transition(double time, const Vector3d& force, const Estimate& x) const {
  const Matrix3d swing = skew(force), R = x.R_wb();
  Square Phi = Square::Identity(size_, size_);
  Phi.block<3, 3>(0, kVelocity).diagonal().setConstant(time);
  Phi.block<3, 3>(kVelocity, kAttitude) = -time * swing;
  Phi.block<3, 3>(0, kAttitude) = -0.5 * time * time * swing;
  for (int k = kNavigation; k < size_; ++k) Phi(k, k) = discretise(laws_[place(k)], time).transition;
  if (counts(gyro_drift_)) {
    const Matrix3d gyro = -R * (1 + x.gyro_scale.array()).inverse().matrix().asDiagonal();
    Phi.block<3, 3>(kAttitude, gyro_drift_) = time * gyro;
    Phi.block<3, 3>(kVelocity, gyro_drift_) = -0.5 * time * time * swing * gyro;
    Phi.block<3, 3>(0, gyro_drift_) = -time * time * time / 6 * swing * gyro;
  }
  if (counts(accel_drift_)) {
    const Matrix3d accel = -R * (1 + x.accel_scale.array()).inverse().matrix().asDiagonal();
    Phi.block<3, 3>(kVelocity, accel_drift_) = time * accel;
    Phi.block<3, 3>(0, accel_drift_) = 0.5 * time * time * accel;
  }
  return Phi;
}

// From the last instant with fixes to this one.
void ErrorsInVariables::propagate(const Estimate& x, const Vector3d& gravity) {
  const Vector3d force = (x.v_wb - velocity_) / duration_ - gravity;
  // The mean over the noise of this time, by Simpson's rule.
  const std::array weights{1.0 / 6, 4.0 / 6, 1.0 / 6};
  const std::array until{transition(0, force, x), transition(duration_ / 2, force, x), transition(duration_, force, x)};
  const Square& Phi = until.back();
  std::array<Element, place(kMost) * place(kMost)> elements;
  Element* end = elements.data();
  for (int row = 0; row < size_; ++row) {
    for (int column = row; column < size_; ++column) {
      const bool changes = row == column ? Phi(row, column) != 1 : Phi(row, column) != 0;
      if (changes) *end++ = {row, column, Phi(row, column)};
    }
  }
  propagate_moments(elements.data(), end, size_, kLanes, moments_.data());

  const Matrix3d R = x.R_wb();
  for (std::ptrdiff_t triad = 0; triad < 2; ++triad) {
    const double noise = triad == 0 ? gyro_ * gyro_time_ : accel_ * accel_time_;
    if (!(triad == 0 ? of_gyro_ : of_accel_)) continue;
    const Vector3d& scale = triad == 0 ? x.gyro_scale : x.accel_scale;
    const int drift = triad == 0 ? gyro_drift_ : accel_drift_;
    Columns mean = Columns::Zero(size_, 3);
    for (std::size_t i = 0; i < until.size(); ++i) {
      const Columns g = until[i].middleCols<3>(triad == 0 ? kAttitude : kVelocity) * R;
      mean += weights[i] * g;
      for (int axis = 0; axis < 3; ++axis) {
        const double factor = 1 + scale(axis), added = weights[i] * noise / (factor * factor * factor);
        const std::ptrdiff_t lane = 3 * triad + axis;
        for (int a = 0; a < kNavigation; ++a) {
          for (int b = 0; b < kNavigation; ++b) {
            double* to = at(a, b) + lane;
            const double more = added * g(a, axis) * g(b, axis);
            to[0] += more;
            to[kOfScore] += more / factor;
          }
        }
      }
    }
    if (!counts(drift) || P_.rows() != size_) continue;
    const Columns carried = Phi.lazyProduct(P_.middleCols<3>(drift));
    for (int axis = 0; axis < 3; ++axis) {
      const double added = -measured_ / square(1 + scale(axis));
      for (int a = 0; a < size_; ++a) {
        for (int b = 0; b < kNavigation; ++b) at(a, b)[3 * triad + axis] += added * carried(a, axis) * mean(b, axis);
      }
    }
  }
  duration_ = measured_ = gyro_time_ = accel_time_ = 0;
}

void ErrorsInVariables::observe(const Estimate& x, const Covariance& P, const Vector3d& gravity, const Update& u,
                                const Linearization& lin, double gyro, bool smoothed) {
  if (!corrects_any()) return;
  const Matrix3d T = ordinary_from_invariant(x).block<3, 3>(kVelocity, kAttitude);
  Eigen::Matrix<double, 3, Eigen::Dynamic, 0, 3, kMost> H(3, size_);
  for (int k = 0; k < size_; ++k) H.col(k) = u.H.col(states_[place(k)]);
  H.middleCols<3>(kAttitude) -= (H.middleCols<3>(kVelocity) * T).eval();
  std::array<std::ptrdiff_t, place(kMost)> seen{};
  std::ptrdiff_t count = 0;
  double observed = 0;  // the size of H C Hᵀ over R
  for (int k = 0; k < size_; ++k) {
    const double weight = H.col(k).cwiseAbs2().cwiseQuotient(u.R.diagonal()).sum();
    if (weight == 0) continue;
    seen[place(count++)] = k;
    for (std::ptrdiff_t lane = 0; lane < kLanes; ++lane)
      observed = std::max(observed, weight * std::abs(at(k, k)[lane]));
  }
  if (count == 0) return;
  if (!instant_) {
    // At rest nothing is added to the moments, and soon no fix observes what is left of them.
    if (duration_ == 0 && observed < kNegligible) return;
    if (duration_ > 0) propagate(x, gravity);
    instant_ = true;
    known_ = false;
    turn_.setZero(size_, 3);
    turn_.middleRows<3>(kAttitude) = x.R_wb();
  }
  if (!known_) P_ = for_given_constants(x, P);
  known_ = true;
  Columns PHt = Columns::Zero(size_, 3);
  for (std::ptrdiff_t i = 0; i < count; ++i) {
    const std::ptrdiff_t k = seen[place(i)];
    PHt += P_.col(k) * H.col(k).transpose();
  }
  const Matrix3d S_inverse = inverse_of_definite(u.R + H.lazyProduct(PHt));
  const Columns K = PHt.lazyProduct(S_inverse);
  P_ -= K.lazyProduct(PHt.transpose()).eval();
  alignas(64) std::array<double, 3 * place(kMost) * place(kLanes)> work;
  alignas(64) std::array<double, place(kLanes)> trace{};
  observe_moments(K.data(), H.data(), S_inverse.data(), seen.data(), count, size_, kLanes, moments_.data(), work.data(),
                  trace.data());
  const double in_rate = smoothed ? 0.5 : 1;
  const bool swings = of_gyro_ && !lin.by_rate_noise.isZero(0);
  const Matrix3d seen_turn = H.lazyProduct(turn_);
  turn_ -= K.lazyProduct(seen_turn);
  for (int axis = 0; axis < 3; ++axis) {
    for (int triad = 0; triad < 2; ++triad) {
      const int lane = 3 * triad + axis;
      sum_.score(lane) += trace[place(lane)];
      sum_.information(lane) += trace[place(lane) + place(kOfScore)];
    }
    if (!swings) continue;
    const double factor = 1 + x.gyro_scale(axis), added = gyro_ * gyro / (factor * factor * factor);
    const Vector3d m = lin.by_rate_noise.col(axis), weighed = S_inverse * m;
    sum_.score(axis) += added * (in_rate + lin.observed_noise) * weighed.dot(seen_turn.col(axis));
    const Eigen::Matrix<double, Eigen::Dynamic, 1, 0, kMost, 1> k = K * m, c = turn_.col(axis);
    for (int a = 0; a < size_; ++a) {
      for (int b = 0; b < size_; ++b)
        at(a, b)[axis] -= added * (in_rate * k(a) * c(b) + lin.observed_noise * c(a) * k(b));
    }
  }
}

std::optional<FalseInformation> ErrorsInVariables::after_fixes(const Estimate& x) {
  if (!instant_) return std::nullopt;
  instant_ = false;
  velocity_ = x.v_wb;
  if (since_ < kEvery) return std::nullopt;
  since_ = 0;
  return std::exchange(sum_, {ScaleScore::Zero(), ScaleScore::Zero()});
}

std::optional<Update> removing(const Vector3d& information, const StateLayout& layout, Block scales,
                               const Covariance& P) {
  if (!layout.has(scales)) return std::nullopt;
  constexpr double kMost = 0.25;     // of what is known: S is negative definite below a third
  constexpr double kNothing = 1e-7;  // in ten hours of two a second less than a hundredth
  const int at = layout.offset(scales);
  const Vector3d variance = P.diagonal().segment<3>(at);
  if (!(variance.minCoeff() > 0) || information.cwiseProduct(variance).maxCoeff() < kNothing) return std::nullopt;
  // An axis without any has a variance all the same.
  const Vector3d part = information.cwiseProduct(variance).cwiseMin(kMost).cwiseMax(1e-3 * kNothing);
  Update u;
  u.H.setZero(3, layout.size());
  u.H.middleCols<3>(at).setIdentity();
  u.PHt = P.middleCols<3>(at);
  u.R = (-variance.cwiseQuotient(part)).asDiagonal();
  u.S = u.PHt.middleRows<3>(at) + u.R;
  u.S_inverse = inverse_of_definite(u.S);
  u.residual.setZero();
  u.observed = at;
  return u;
}

ErrorVector pull_of(const ScaleScore& score, const StateLayout& layout, const Covariance& P) {
  ErrorVector pull = ErrorVector::Zero(layout.size());
  for (Eigen::Index k = 0; k < 2; ++k) {
    if (layout.has(kScales[k])) pull += P.middleCols<3>(layout.offset(kScales[k])) * score.segment<3>(3 * k);
  }
  return pull;
}

void add_score(ErrorVector& lambda, const StateLayout& layout, const ScaleScore& score) {
  for (Eigen::Index k = 0; k < 2; ++k) {
    if (layout.has(kScales[k])) lambda.segment<3>(layout.offset(kScales[k])) += score.segment<3>(3 * k);
  }
}

}  // namespace piste
