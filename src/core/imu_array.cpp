#include "piste/core/imu_array.h"

#include <algorithm>
#include <cmath>

#include "piste/core/error.h"

namespace piste {
namespace {

// Columns that with the unit vector `first` are an orthonormal basis: those of the Householder reflection that turns
// the first axis into it, but for the first.
ImuMatrix complement(const ImuVector& first) {
  const Eigen::Index n = first.size();
  ImuVector v = first;
  v(0) -= 1;
  const double square = v.squaredNorm();
  ImuMatrix out = ImuMatrix::Zero(n, n - 1);
  for (Eigen::Index k = 1; k < n; ++k) {
    out(k, k - 1) = 1;
    if (square > 0) out.col(k - 1) -= 2 * v(k) / square * v;
  }
  return out;
}

TriadErrors mean_triad(std::span<const ImuSensor> imus, TriadMember triad) {
  const ImuVector w = imu_weights(imus, triad);
  const auto combined = [&](ImuErrorKind error) { return w.cwiseProduct(imu_sigmas(imus, triad, error)).norm(); };
  TriadErrors out = imus.front().*triad;
  Vector3d variance = Vector3d::Zero();
  for (std::size_t i = 0; i < imus.size(); ++i) {
    const TriadErrors& unit = imus[i].*triad;
    variance += w(static_cast<Eigen::Index>(i)) * w(static_cast<Eigen::Index>(i)) * unit.noise_variance();
    if (unit.range > 0) out.range = out.range > 0 ? std::min(out.range, unit.range) : unit.range;
  }
  out.set_densities(variance.cwiseSqrt());
  out.bias = combined(ImuErrorKind::kBias);
  out.scale = combined(ImuErrorKind::kScale);
  out.cross_axis = 0;  // of several IMUs it is not modelled
  out.drift = parity_drift(imus, triad);
  const double drift = combined(ImuErrorKind::kDrift);
  out.drift.sigma = out.drift.kind == DriftProcess::Kind::kGaussMarkov ? drift : 0;
  out.drift.density = out.drift.kind == DriftProcess::Kind::kRandomWalk ? drift : 0;
  return out;
}

}  // namespace

ImuVector imu_weights(const ImuVector& noise) {
  const ImuVector inverse = noise.cwiseAbs2().cwiseInverse();
  return inverse / inverse.sum();
}

ImuVector imu_weights(std::span<const ImuSensor> imus, TriadMember triad) {
  return imu_weights(imu_noise(imus, triad));
}

ImuMatrix parity_rows(const ImuVector& noise) {
  const ImuVector inverse = noise.cwiseInverse();
  return parity_noise(noise) * inverse.asDiagonal() * complement(inverse.normalized());
}

double parity_noise(const ImuVector& noise) { return parity_sigma(noise); }

ErrorSplit split_errors(const ImuVector& weights, const ImuVector& sigma) {
  const Eigen::Index n = weights.size();
  const ImuVector w = sigma.cwiseProduct(weights);
  const double mean = w.norm();
  if (!(mean > 0)) return {ImuVector::Ones(n), ImuMatrix::Zero(n, n - 1)};
  return {sigma.cwiseProduct(w) / (mean * mean), sigma.asDiagonal() * complement(w / mean) / parity_sigma(sigma)};
}

double parity_sigma(const ImuVector& sigma) {
  return std::sqrt(sigma.squaredNorm() / static_cast<double>(sigma.size()));
}

TurnedScale::TurnedScale(const Matrix3d& R) : R_(R) {
  std::array order{0, 1, 2};
  do {
    const Matrix3d ordered = R(Eigen::all, order);
    if (ordered.diagonal().squaredNorm() <= R_.diagonal().squaredNorm()) continue;
    order_ = order;
    R_ = ordered;
  } while (std::ranges::next_permutation(order).found);
}

bool TurnedScale::at_right_angles() const {
  constexpr double kRightAngle = 1e-9;  // of an element, relative to 1
  return R_.diagonal().cwiseAbs().minCoeff() > 1 - kRightAngle;
}

Matrix3d TurnedScale::effect(const Vector3d& s) const { return R_ * s.asDiagonal() * R_.transpose(); }

Matrix3d TurnedScale::by_scales(const Vector3d& u) const { return R_ * (R_.transpose() * u).asDiagonal(); }

ImuVector imu_noise(std::span<const ImuSensor> imus, TriadMember triad) {
  ImuVector out(static_cast<Eigen::Index>(imus.size()));
  for (std::size_t i = 0; i < imus.size(); ++i) out(static_cast<Eigen::Index>(i)) = (imus[i].*triad).noise;
  return out;
}

ImuVector imu_sigmas(std::span<const ImuSensor> imus, TriadMember triad, ImuErrorKind error) {
  ImuVector out(static_cast<Eigen::Index>(imus.size()));
  for (std::size_t i = 0; i < imus.size(); ++i) {
    const TriadErrors& unit = imus[i].*triad;
    const bool walks = unit.drift.kind == DriftProcess::Kind::kRandomWalk;
    const bool varies = unit.drift.kind == DriftProcess::Kind::kGaussMarkov;
    const double drift = walks ? unit.drift.density : varies ? unit.drift.sigma : 0;
    out(static_cast<Eigen::Index>(i)) = error == ImuErrorKind::kBias    ? unit.bias
                                        : error == ImuErrorKind::kScale ? unit.scale
                                                                        : drift;
  }
  return out;
}

DriftProcess parity_drift(std::span<const ImuSensor> imus, TriadMember triad) {
  using Kind = DriftProcess::Kind;
  const ImuVector sigma = imu_sigmas(imus, triad, ImuErrorKind::kDrift);
  DriftProcess out;
  double time = 0;
  for (std::size_t i = 0; i < imus.size(); ++i) {
    const DriftProcess& drift = (imus[i].*triad).drift;
    if (drift.kind == Kind::kNone) continue;
    if (out.kind != Kind::kNone && out.kind != drift.kind) {
      throw ConfigError("",
                        "the drift of one unit is a random walk and that of another is Gauss-Markov; several IMUs as "
                        "one need one kind: give both sensor files the same `process`");
    }
    out.kind = drift.kind;
    const double variance = sigma(static_cast<Eigen::Index>(i)) * sigma(static_cast<Eigen::Index>(i));
    time += variance * drift.correlation_time;
  }
  const double all = parity_sigma(sigma);
  if (out.kind == Kind::kGaussMarkov) {
    out.sigma = all;
    out.correlation_time = time / sigma.squaredNorm();
  }
  if (out.kind == Kind::kRandomWalk) out.density = all;
  return out;
}

ImuSensor mean_sensor(std::span<const ImuSensor> imus) {
  ImuSensor out = imus.front();
  out.gyro = mean_triad(imus, &ImuSensor::gyro);
  out.accel = mean_triad(imus, &ImuSensor::accel);
  out.gyro_g_sensitivity = 0;
  return out;
}

}  // namespace piste
