#include "piste/solve/noise_score.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <array>
#include <cmath>
#include <utility>

#include "math/wide.h"

namespace piste {
namespace {

constexpr std::array kScales{Block::kGyroScale, Block::kAccelScale};
constexpr double kEvery = 0.5;  // s between two scores at least: several fixes of a fast receiver at a time

// Of errors of position, velocity and attitude over a time with a mean specific force, both in the world frame.
Eigen::Matrix<double, 9, 9> transition(double time, const Vector3d& force) {
  Eigen::Matrix<double, 9, 9> Phi = Eigen::Matrix<double, 9, 9>::Identity();
  Phi.block<3, 3>(0, 3).diagonal().setConstant(time);
  Phi.block<3, 3>(3, 6) = -time * skew(force);
  Phi.block<3, 3>(0, 6) = -0.5 * time * time * skew(force);
  return Phi;
}

// Eliminates the first `count` rows of a symmetric matrix, of which the lower half is there.
PISTE_WIDE void eliminate(double* C, std::ptrdiff_t size, std::ptrdiff_t count) {
  for (std::ptrdiff_t k = 0; k < count; ++k) {
    const double* __restrict pivot = C + k * size;
    if (!(pivot[k] > 0)) continue;  // known exactly
    const double inverse = 1 / pivot[k];
    for (std::ptrdiff_t j = k + 1; j < size; ++j) {
      double* __restrict column = C + j * size;
      const double factor = pivot[j] * inverse;
      for (std::ptrdiff_t i = j; i < size; ++i) column[i] -= factor * pivot[i];
    }
  }
}

// Divides a sum by how often it has what it has at most, if it has more.
void bound(Eigen::Matrix<double, 9, 9>& sum, double part) {
  if (!std::isfinite(part)) {
    sum.setZero();
  } else if (part > 1) {
    sum /= part;
  }
}

}  // namespace

NoiseScore::NoiseScore(const FilterOptions& options, const StateLayout& layout) {
  const double gyro = options.sensor.gyro.noise, accel = options.sensor.accel.noise;
  if (layout.has(Block::kGyroScale) && options.attitude.empty()) gyro_ = gyro * gyro;
  if (layout.has(Block::kAccelScale)) accel_ = accel * accel;
}

// For given errors of everything else: what a bias hides of the tilt is not what the noise turns.
NoiseScore::Navigation NoiseScore::known(const Estimate& x, const Covariance& P) {
  constexpr int kNavigation = 9;
  const Eigen::Index others = P.rows() - kNavigation, size = P.rows();
  // The slow states first; eliminating them leaves the covariance of the others for given values of them (Schur's
  // complement). Only the lower half is there.
  Covariance C(size, size);
  C.topLeftCorner(others, others) = P.bottomRightCorner(others, others);
  C.bottomLeftCorner(kNavigation, others) = P.topRightCorner(kNavigation, others);
  C.bottomRightCorner<kNavigation, kNavigation>() = P.topLeftCorner<kNavigation, kNavigation>();
  eliminate(C.data(), size, others);
  const Navigation lower = C.bottomRightCorner<kNavigation, kNavigation>();
  const Navigation T = ordinary_from_invariant(x);
  return T * lower.selfadjointView<Eigen::Lower>() * T.transpose();
}

void NoiseScore::before_fix(const Estimate& x, const Covariance& P) {
  if (gyro_ + accel_ == 0 || duration_ == 0) return;
  if (!std::exchange(counted_, true)) ++fixes_;
  if (!before_ && duration_ >= kEvery) before_ = known(x, P);
}

void NoiseScore::swung(const Estimate& x, const Update& u, const Linearization& lin, double gyro, bool smoothed) {
  if (gyro_ == 0 || duration_ == 0 || lin.by_rate_noise.isZero(0)) return;
  const Navigation T = ordinary_from_invariant(x);
  const Matrix3d noise = u.S_inverse * lin.by_rate_noise;
  const Eigen::Matrix<double, 9, 3> corrected = T * u.PHt.topRows<9>() * noise;
  // T's inverse changes the sign of its one block, of the velocity by the attitude.
  Eigen::Matrix<double, 9, 3> seen = u.H.leftCols<9>().transpose() * noise;
  seen.bottomRows<3>() -= T.block<3, 3>(3, 6).transpose() * seen.middleRows<3>(3);
  const auto add_to = [&](Swing& swing, double part) {
    swing.corrected += part * gyro * corrected;
    swing.seen += part * gyro * seen;
  };
  add_to(noisy_, lin.told_noise);
  add_to(smoothed ? smoothed_ : noisy_, 1);
}

// Λ before this fix, from the one before the fixes since the last score. All of them count as this one, and `pushed` is
// the mean specific force meanwhile. N likewise, of which `made` comes between two fixes.
// Returns I − K H.
NoiseScore::Navigation NoiseScore::look_ahead(const Navigation& after, const Vector3d& pushed, const Navigation& made) {
  const Eigen::LLT<Navigation> root(*before_);
  if (root.info() != Eigen::Success) {
    later_.setZero();
    made_.setZero();
    found_.setZero();
    return Navigation::Identity();
  }
  const Navigation inverse = root.solve(Navigation::Identity());
  Navigation kept = after * inverse;
  Navigation told = inverse - inverse * kept;
  const Navigation step = transition(duration_ / fixes_, pushed) * kept;
  Navigation A = step, added = made;
  for (int n = fixes_;; A = A * A) {
    if (n % 2 == 1) {
      later_ = A.transpose() * later_ * A + told;
      made_ = A * made_ * A.transpose() + added;
    }
    if ((n /= 2) == 0) break;
    told += A.transpose() * told * A;
    added += A * added * A.transpose();
  }
  if (!later_.allFinite()) later_ = inverse;
  // No later fix tells more than all that is to be known, which P⁻¹ is: after an outage the fixes before it would.
  const Navigation L = root.matrixL(), part = L.transpose() * later_ * L;
  const Eigen::SelfAdjointEigenSolver<Navigation> known_part(0.5 * (part + part.transpose()));
  const Navigation W = root.matrixU().solve(known_part.eigenvectors());
  later_ = W * known_part.eigenvalues().cwiseMax(0).cwiseMin(1).asDiagonal() * W.transpose();
  Navigation found = later_ * made * later_;
  A = step;
  for (int n = fixes_;; A = A * A) {
    if (n % 2 == 1) found_ = A.transpose() * found_ * A + found;
    if ((n /= 2) == 0) break;
    found += A.transpose() * found * A;
  }
  // Nor is more of the errors made by this noise than there is, nor more found of it than is told.
  bound(made_, made_.cwiseProduct(inverse).sum() / static_cast<double>(inverse.rows()));
  bound(found_, 2 * found_.cwiseProduct(*before_).sum() / later_.cwiseProduct(*before_).sum());
  return kept;
}

std::optional<ToldByNoise> NoiseScore::after_fixes(const Estimate& x, const Covariance& P, const Vector3d& gravity) {
  counted_ = false;
  if (!before_) return std::nullopt;
  const Vector3d pushed = (x.v_wb - velocity_) / duration_ - gravity;
  // The mean over the time between two fixes, by Simpson's rule.
  const double interval = duration_ / fixes_;
  const std::array weights{1.0 / 6, 4.0 / 6, 1.0 / 6};
  const std::array untils{transition(0, pushed), transition(interval / 2, pushed), transition(interval, pushed)};
  Navigation made = Navigation::Zero();
  for (std::size_t i = 0; i < 3; ++i) {
    const Eigen::Matrix<double, 9, 3> turned = untils[i].rightCols<3>();
    made += weights[i] * gyro_ * interval * turned * turned.transpose();
  }
  const Navigation kept = look_ahead(known(x, P), pushed, made);
  // Where the filter admitted an error of its own, the covariance has grown, and this is no I − K H.
  if (kept.trace() > static_cast<double>(kept.rows())) noisy_ = smoothed_ = {};
  const Matrix3d R = x.R_wb();
  ToldByNoise told{ScaleScore::Zero(), ScaleScore::Zero()};
  ScaleScore& score = told.score;
  for (std::size_t i = 0; i < 3; ++i) {
    const Eigen::Matrix<double, 9, 3> turned = untils[i].rightCols<3>() * R, moved = untils[i].middleCols<3>(3) * R;
    score.head<3>() += weights[i] * (turned.transpose() * later_ * turned).diagonal();
    score.tail<3>() += weights[i] * (moved.transpose() * later_ * moved).diagonal();
  }
  score.head<3>() *= gyro_ * gyro_time_;
  score.tail<3>() *= accel_ * accel_time_;
  const Navigation& until = untils.back();
  const auto told_by = [&](const Swing& swing, const Navigation& later) -> Eigen::Matrix<double, 9, 3> {
    return swing.seen - kept.transpose() * until.transpose() * later * until * swing.corrected;
  };
  Eigen::Matrix<double, 9, 3> X = told_by(noisy_, later_);
  const Eigen::Matrix<double, 9, 3> smoothed = told_by(smoothed_, later_);
  X += told_by(smoothed_, later_ - 2 * found_) - 2 * later_ * made_ * smoothed;
  ScaleScore factor;
  factor << 1 + x.gyro_scale.array(), 1 + x.accel_scale.array();
  told.information = score.array() * factor.array().pow(-4);
  score.head<3>() += gyro_ * (R.transpose() * X.bottomRows<3>()).diagonal();
  score.array() *= factor.array().pow(-3);
  before_.reset();
  noisy_ = smoothed_ = {};
  velocity_ = x.v_wb;
  duration_ = gyro_time_ = accel_time_ = 0;
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
