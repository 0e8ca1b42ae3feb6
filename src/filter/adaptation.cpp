#include "filter/adaptation.h"

#include <fmt/format.h>

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "piste/math/statistics.h"

namespace piste {
namespace {

constexpr std::array<const char*, 2> kTriads{"gyro_noise", "accel_noise"};
constexpr double kComparable = 1.5;  // s between two residuals outside the gate whose change is the source's noise

double prior_sigma(const AdaptationOptions& options) { return std::log(options.within); }

// Whether the user declares the errors of a receiver white, whose positions are `source`.
bool is_white(const std::vector<GnssOptions>& receivers, std::string_view source) {
  for (std::size_t i = 0; i < receivers.size(); ++i) {
    if (source == fmt::format("gnss[{}].position", i)) return receivers[i].white;
  }
  return true;
}

// A variance that is far too small gives one innovation of many sigmas, whose score far exceeds the expected
// information. The observed information is larger in the same ratio, and bounds the step.
double observed_over_expected(double nis, int rows) { return std::max(1.0, nis / rows); }

}  // namespace

Adaptation::Adaptation(const FilterOptions& options, const StateLayout& layout, const MeasurementSources& sources) {
  if (!options.adapt) return;
  options_ = *options.adapt;
  considered_ = Considered(options, layout);
  for (const MeasurementSource& source : sources.all()) {
    slot_.push_back(source.adapted ? static_cast<int>(names_.size()) : -1);
    if (!source.adapted) continue;
    names_.push_back(source.name);
    const bool kept = source.name.ends_with(".position") && !is_white(options.gnss, source.name);
    least_.push_back(kept ? 0 : -furthest());
  }
  last_.resize(names_.size());
  least_.resize(names_.size() + kTriads.size(), -furthest());
  names_.insert(names_.end(), kTriads.begin(), kTriads.end());
  const auto size = static_cast<Eigen::Index>(names_.size());
  log_.setZero(size);
  variance_ = square(prior_sigma(options_)) * Eigen::MatrixXd::Identity(size, size);
  seen_.setZero(size, 3);
  gain_.setZero(size, 3);
  drop_.setZero(size, 3);
  imu_.assign(kTriads.size(), Covariance::Zero(layout.size(), layout.size()));
}

double Adaptation::variance_of(int source) const {
  if (!on()) return 1;
  const int slot = slot_[static_cast<std::size_t>(source)];
  return slot < 0 ? 1 : std::exp(log_(slot));
}

std::array<double, 2> Adaptation::imu_variances() const {
  if (!on()) return {1, 1};
  return {std::exp(log_(log_.size() - 2)), std::exp(log_(log_.size() - 1))};
}

StepNoise Adaptation::of(const StepNoise& stated) const {
  if (!on()) return stated;
  const auto [gyro, accel] = imu_variances();
  return {gyro * stated.gyro, accel * stated.accel};
}

void Adaptation::propagate(const StateLayout& layout, const Transition& t, const StepNoise& noise, double dt) {
  if (!on()) return;
  Transition alone = t;
  alone.variance.fill(Vector3d::Zero());
  const std::array densities{noise.gyro, noise.accel};
  for (std::size_t triad = 0; triad < imu_.size(); ++triad) {
    alone.noise.setZero();
    if (dt > 0) {
      const Eigen::Matrix<double, 9, 3> effect = t.imu.middleCols<3>(3 * static_cast<Eigen::Index>(triad));
      alone.noise.noalias() = effect * (densities[triad] / dt).asDiagonal() * effect.transpose();
    }
    piste::propagate(imu_[triad], layout, alone);
  }
}

void Adaptation::correct(const StateLayout& layout, const Update& u, const ResetJacobian& G) {
  if (!on()) return;
  // M ← A M Aᵀ with A = I − K H: dP⁺ = A dP⁻ Aᵀ, as the derivative of P⁺ by the optimal gain is zero.
  const auto K = gain(u);
  for (Covariance& M : imu_) {
    Eigen::Matrix<double, Eigen::Dynamic, 3, 0, kMostStates, 3> MHt(M.rows(), 3);
    MHt.noalias() = M.lazyProduct(u.H.transpose());
    const Matrix3d HMHt = u.H.lazyProduct(MHt);
    MHt -= 0.5 * K.lazyProduct(HMHt);
    considered_.keep(M, [&] {
      M -= K.lazyProduct(MHt.transpose());
      M -= MHt.lazyProduct(K.transpose());
    });
    reset(M, layout, G);
  }
}

// Propagates the processes to this time: they decay towards the stated noise.
void Adaptation::forget(double time) {
  const double dt = time_ > 0 ? time - time_ : 0;
  time_ = time;
  if (dt == 0) return;
  const Eigen::Index sources = log_.size() - static_cast<Eigen::Index>(imu_.size());
  const double of_source = std::exp(-dt / options_.time), of_imu = std::exp(-dt / options_.imu_time);
  for (Eigen::Index k = 0; k < log_.size(); ++k) {
    const double a = k < sources ? of_source : of_imu;
    log_(k) *= a;
    variance_.row(k) *= a;
    variance_.col(k) *= a;
    variance_(k, k) += (1 - a * a) * square(prior_sigma(options_));
  }
}

void Adaptation::learn(int source, double time, const Update& u, double bound) {
  if (!on()) return;
  const int slot = slot_[static_cast<std::size_t>(source)];
  if (slot < 0) return;
  forget(time);
  Last& last = last_[static_cast<std::size_t>(slot)];
  if (u.nis <= bound) {
    learn_inside(slot, u);
  } else if (last.rows == u.rows && time - last.time < kComparable) {
    learn_outside(slot, u, last, bound);
  }
  last = {time, u.residual, u.R, u.rows};
  keep_in_bounds();
}

void Adaptation::learn_inside(Eigen::Index source, const Update& u) {
  const std::array<Eigen::Index, 3> which{source, log_.size() - 2, log_.size() - 1};
  const Matrix3d used = Vector3d(1, u.rows > 1, u.rows > 2).asDiagonal();
  std::array<Matrix3d, 3> weighted{u.S_inverse * u.R * used};
  for (std::size_t k = 0; k < imu_.size(); ++k) {
    weighted[k + 1] = u.S_inverse * u.H.lazyProduct(imu_[k].lazyProduct(u.H.transpose()).eval());
  }
  const Vector3d z = u.S_inverse * u.residual;
  const double observed = observed_over_expected(u.nis, u.rows);
  Vector3d score;
  Matrix3d information, known;
  for (Eigen::Index i = 0; i < 3; ++i) {
    const Matrix3d& w = weighted[static_cast<std::size_t>(i)];
    score(i) = 0.5 * ((w.transpose() * u.residual).dot(z) - w.trace());
    for (Eigen::Index j = 0; j < 3; ++j) {
      information(i, j) = 0.5 * observed * w.cwiseProduct(weighted[static_cast<std::size_t>(j)].transpose()).sum();
      known(i, j) = variance_(which[static_cast<std::size_t>(i)], which[static_cast<std::size_t>(j)]);
    }
    seen_.col(i) = variance_.col(which[static_cast<std::size_t>(i)]);
  }
  // V⁺ = (V⁻¹ + E I Eᵀ)⁻¹, where the columns of E select the three factors, and ln θ changes by V⁺ E s.
  const Matrix3d inverse = (Matrix3d::Identity() + information * known).inverse();
  const Matrix3d lost = information * inverse.transpose();
  gain_.noalias() = seen_.lazyProduct(inverse);
  log_.noalias() += gain_.lazyProduct(score);
  drop_.noalias() = seen_.lazyProduct(0.5 * (lost + lost.transpose()));
  variance_.noalias() -= drop_.lazyProduct(seen_.transpose());
}

void Adaptation::learn_outside(Eigen::Index source, const Update& u, const Last& last, double bound) {
  const Vector3d change = u.residual - last.residual;
  Matrix3d spread = Matrix3d::Identity();
  spread.topLeftCorner(u.rows, u.rows) = (u.R + last.R).topLeftCorner(u.rows, u.rows);
  const double nis = std::min(bound, change.dot(spread.inverse() * change));
  const double information = 0.5 * u.rows * observed_over_expected(nis, u.rows), score = 0.5 * (nis - u.rows);
  const double shrink = 1 / (1 + information * variance_(source, source));
  seen_.col(0) = variance_.col(source);
  log_ += shrink * score * seen_.col(0);
  drop_.col(0) = shrink * information * seen_.col(0);
  variance_.noalias() -= drop_.col(0).lazyProduct(seen_.col(0).transpose());
}

void Adaptation::keep_in_bounds() {
  for (Eigen::Index k = 0; k < log_.size(); ++k) {
    log_(k) = std::clamp(log_(k), least_[static_cast<std::size_t>(k)], furthest());
  }
}

void Adaptation::append_to(std::vector<double>& row) const {
  for (const double log_variance : log_) row.push_back(std::exp(0.5 * log_variance));
}

}  // namespace piste
