#include "filter/noise_score.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "math/eigenpairs.h"
#include "math/square.h"
#include "model/imu_errors.h"

namespace piste {
namespace {

using Vector6d = Eigen::Matrix<double, 6, 1>;

constexpr std::array kScales{Block::kGyroScale, Block::kAccelScale};
constexpr int kVelocity = 3, kAttitude = 6;  // among the errors of navigation

std::size_t place(int k) { return static_cast<std::size_t>(k); }

bool is_positive(const Square& X) { return X.allFinite() && X.llt().info() == Eigen::Success; }

// No later fix tells more than all that is to be known, which is the inverse of the covariance: after an outage the
// fixes before it would. Nor less than nothing. `root`: of this covariance.
void bound_information(Square& information, const Eigen::LLT<Square>& root) {
  constexpr double kRounding = 1e-9;
  const Square L = root.matrixL(), part = symmetric(turned(L, information));
  const Square one = Square::Identity(part.rows(), part.rows());
  if (is_positive(one - part) && is_positive(part + kRounding * one)) return;
  const Eigenpairs known_part = eigenpairs(part);
  const Square W = root.matrixU().solve(known_part.vectors);
  information = W.lazyProduct(known_part.values.cwiseMax(0).cwiseMin(1).asDiagonal() * W.transpose());
}

// Divides a sum by how often it has what it has at most, if it has more.
void bound(Square& sum, double part) {
  if (!std::isfinite(part)) {
    sum.setZero();
  } else if (part > 1) {
    sum /= part;
  }
}

}  // namespace

NoiseScore::NoiseScore(const FilterOptions& options, const StateLayout& layout) {
  const double gyro = options.sensor.gyro.noise, accel = options.sensor.accel.noise;
  if (options.estimates(Block::kGyroScale) && options.attitude.empty()) gyro_ = gyro * gyro;
  if (options.estimates(Block::kAccelScale)) accel_ = accel * accel;
  for (int k = 0; k < kNavigation; ++k) states_[place(k)] = k;
  for (const Block b : layout.blocks()) {
    // What several IMUs differ by has no part in the motion.
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
  for (Square* m : {&later_, &made_, &found_}) m->setZero(size_, size_);
  forget_swings();
}

void NoiseScore::forget_swings() {
  for (Columns* m : {&noisy_.corrected, &noisy_.seen, &smoothed_.corrected, &smoothed_.seen}) m->setZero(size_, 3);
}

// For given constants: what a bias hides of the tilt is not what the noise turns.
NoiseScore::Square NoiseScore::known(const Estimate& x, const Covariance& P) const {
  // The constants first; eliminating them leaves the covariance of the others for given values of them (Schur's
  // complement). Only the lower half is there.
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
  Square all = C.bottomRightCorner(size_, size_).selfadjointView<Eigen::Lower>();
  const Matrix3d T = ordinary_from_invariant(x).block<3, 3>(kVelocity, kAttitude);
  for (const int drift : {gyro_drift_, accel_drift_}) {
    if (drift > 0 && !(lasted_ > laws_[place(drift)].correlation_time)) hold(all, drift);
  }
  all.middleRows<3>(kVelocity) += T.lazyProduct(all.middleRows<3>(kAttitude)).eval();
  all.middleCols<3>(kVelocity) += all.middleCols<3>(kAttitude).lazyProduct(T.transpose()).eval();
  return all;
}

// Over a time with a mean specific force in the world frame.
NoiseScore::Square NoiseScore::transition(double time, const Vector3d& force, const Estimate& x) const {
  const Matrix3d swing = skew(force), R = x.R_wb();
  const auto counts = [&](int first) { return first > 0 && lasted_ > laws_[place(first)].correlation_time; };
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

void NoiseScore::before_fix(const Estimate& x, const Covariance& P) {
  if (gyro_ + accel_ == 0 || duration_ == 0) return;
  if (std::exchange(moved_, false)) ++fixes_;
  if (!before_ && duration_ >= kEvery) before_ = known(x, P);
}

void NoiseScore::swung(const Estimate& x, const Update& u, const Linearization& lin, double gyro, bool smoothed) {
  if (gyro_ == 0 || duration_ == 0 || lin.by_rate_noise.isZero(0)) return;
  const Matrix3d T = ordinary_from_invariant(x).block<3, 3>(kVelocity, kAttitude);
  const Matrix3d noise = u.S_inverse * lin.by_rate_noise;
  Columns corrected(size_, 3), seen(size_, 3);
  for (int k = 0; k < size_; ++k) {
    corrected.row(k) = u.PHt.row(states_[place(k)]) * noise;
    seen.row(k) = u.H.col(states_[place(k)]).transpose() * noise;
  }
  corrected.middleRows<3>(kVelocity) += T.lazyProduct(corrected.middleRows<3>(kAttitude));
  seen.middleRows<3>(kAttitude) -= T.transpose().lazyProduct(seen.middleRows<3>(kVelocity));
  const auto add_to = [&](Swing& swing, double part) {
    swing.corrected += part * gyro * corrected;
    swing.seen += part * gyro * seen;
  };
  add_to(noisy_, lin.observed_noise);
  add_to(smoothed ? smoothed_ : noisy_, 1);
}

// Λ before this fix, from the one before the fixes since the last score. All of them count as this one, and `until` is
// the transition between two. N likewise, of which `made` comes between two fixes.
// Returns I − K H.
NoiseScore::Square NoiseScore::look_ahead(const Square& after, const Square& until, const Square& made) {
  const Eigen::LLT<Square> root(*before_);
  if (root.info() != Eigen::Success) {
    for (Square* m : {&later_, &made_, &found_}) m->setZero();
    return Square::Identity(size_, size_);
  }
  const Square inverse = root.solve(Square::Identity(size_, size_));
  Square kept = product(after, inverse);
  const Square step = product(until, kept);
  recur(later_, step, symmetric(inverse - product(inverse, kept)), fixes_);
  recur(made_, step.transpose(), made, fixes_);
  if (!later_.allFinite()) later_ = inverse;
  bound_information(later_, root);
  recur(found_, step, symmetric(turned(later_, made)), fixes_);
  // Nor is more of the errors made by this noise than there is, nor more found of it than is told.
  bound(made_, made_.cwiseProduct(inverse).sum() / size_);
  bound(found_, 2 * found_.cwiseProduct(*before_).sum() / later_.cwiseProduct(*before_).sum());
  return kept;
}

std::optional<NoiseInformation> NoiseScore::after_fixes(const Estimate& x, const Covariance& P,
                                                        const Vector3d& gravity) {
  if (!before_) return std::nullopt;
  const Vector3d pushed = (x.v_wb - velocity_) / duration_ - gravity;
  // The mean over the time between two fixes, by Simpson's rule.
  const double interval = duration_ / fixes_;
  const std::array weights{1.0 / 6, 4.0 / 6, 1.0 / 6};
  const std::array untils{transition(0, pushed, x), transition(interval / 2, pushed, x),
                          transition(interval, pushed, x)};
  const Square& until = untils.back();
  Square made = Square::Zero(size_, size_);
  for (std::size_t i = 0; i < 3; ++i) {
    const Columns turning = untils[i].middleCols<3>(kAttitude);
    made += weights[i] * gyro_ * interval * turning.lazyProduct(turning.transpose());
  }
  const Square kept = look_ahead(known(x, P), until, made);
  // Where the filter admitted an error of its own, the covariance has grown, and this is no I − K H.
  if (kept.trace() > size_) forget_swings();
  const Matrix3d R = x.R_wb();
  Vector6d noise = Vector6d::Zero(), drift = Vector6d::Zero();
  // Λ Φ P_d. In the covariance before the fix, Φ P_d has decayed with the drift, which has grown by its own noise.
  const auto of_drift = [&](int first) -> Columns {
    const DiscreteProcess d = discretise(laws_[place(first)], interval);
    Columns carried = before_->middleCols<3>(first);
    carried.middleRows<3>(first).diagonal().array() -= d.variance;
    return later_.lazyProduct(carried / d.transition);
  };
  const auto counts = [&](int first) { return first > 0 && lasted_ > laws_[place(first)].correlation_time; };
  const Columns of_gyro = counts(gyro_drift_) ? of_drift(gyro_drift_) : Columns::Zero(size_, 3);
  const Columns of_accel = counts(accel_drift_) ? of_drift(accel_drift_) : Columns::Zero(size_, 3);
  for (std::size_t i = 0; i < 3; ++i) {
    const Columns turning = untils[i].middleCols<3>(kAttitude) * R, moving = untils[i].middleCols<3>(kVelocity) * R;
    const auto add_to = [&](Vector6d& sum, Eigen::Index triad, const Columns& by, const Columns& seen) {
      sum.segment<3>(3 * triad) += weights[i] * by.cwiseProduct(seen).colwise().sum().transpose();
    };
    add_to(noise, 0, turning, later_.lazyProduct(turning));
    add_to(noise, 1, moving, later_.lazyProduct(moving));
    add_to(drift, 0, turning, of_gyro);
    add_to(drift, 1, moving, of_accel);
  }
  noise.head<3>() *= gyro_ * gyro_time_;
  noise.tail<3>() *= accel_ * accel_time_;
  drift *= measured_;
  if (gyro_ == 0) drift.head<3>().setZero();
  if (accel_ == 0) drift.tail<3>().setZero();
  const auto told_by = [&](const Swing& swing, const Square& later) -> Columns {
    const Columns corrected = until.lazyProduct(swing.corrected), told = later.lazyProduct(corrected);
    const Columns before = until.transpose().lazyProduct(told);
    return swing.seen - kept.transpose().lazyProduct(before);
  };
  Columns X = told_by(noisy_, later_);
  const Columns held = made_.lazyProduct(told_by(smoothed_, later_));
  X += told_by(smoothed_, later_ - 2 * found_) - 2 * later_.lazyProduct(held);
  Vector6d factor;
  factor << 1 + x.gyro_scale.array(), 1 + x.accel_scale.array();
  NoiseInformation told{noise, noise.array() * factor.array().pow(-4)};
  told.score.head<3>() += gyro_ * (R.transpose() * X.middleRows<3>(kAttitude)).diagonal();
  told.score.array() *= factor.array().pow(-3);
  told.score.array() -= drift.array() * factor.array().pow(-2);
  before_.reset();
  forget_swings();
  velocity_ = x.v_wb;
  duration_ = measured_ = gyro_time_ = accel_time_ = 0;
  fixes_ = 0;
  return told;
}

std::optional<Update> taking(const Vector3d& information, const StateLayout& layout, Block scales,
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
