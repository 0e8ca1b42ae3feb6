#include "piste/core/imu_array.h"

#include <algorithm>
#include <cmath>

#include "piste/core/error.h"

namespace piste {
namespace {

// Columns that with the unit vector `first` are an orthonormal basis: those of the Householder reflection that turns
// the first axis into it, but for the first.
UnitMatrix complement(const UnitVector& first) {
  const Eigen::Index n = first.size();
  UnitVector v = first;
  v(0) -= 1;
  const double square = v.squaredNorm();
  UnitMatrix out = UnitMatrix::Zero(n, n - 1);
  for (Eigen::Index k = 1; k < n; ++k) {
    out(k, k - 1) = 1;
    if (square > 0) out.col(k - 1) -= 2 * v(k) / square * v;
  }
  return out;
}

TriadErrors mean_triad(std::span<const ImuSensor> units, TriadMember triad) {
  const UnitVector w = unit_weights(units, triad);
  const auto combined = [&](UnitError error) { return w.cwiseProduct(unit_sigmas(units, triad, error)).norm(); };
  TriadErrors out = units.front().*triad;
  Vector3d variance = Vector3d::Zero();
  for (std::size_t i = 0; i < units.size(); ++i) {
    const TriadErrors& unit = units[i].*triad;
    variance += w(static_cast<Eigen::Index>(i)) * w(static_cast<Eigen::Index>(i)) * unit.noise_variance();
    if (unit.range > 0) out.range = out.range > 0 ? std::min(out.range, unit.range) : unit.range;
  }
  out.set_densities(variance.cwiseSqrt());
  out.bias = combined(UnitError::kBias);
  out.scale = combined(UnitError::kScale);
  out.drift = parity_drift(units, triad);
  const double drift = combined(UnitError::kDrift);
  out.drift.sigma = out.drift.kind == DriftProcess::Kind::kGaussMarkov ? drift : 0;
  out.drift.density = out.drift.kind == DriftProcess::Kind::kRandomWalk ? drift : 0;
  return out;
}

}  // namespace

UnitVector unit_weights(const UnitVector& noise) {
  const UnitVector inverse = noise.cwiseAbs2().cwiseInverse();
  return inverse / inverse.sum();
}

UnitVector unit_weights(std::span<const ImuSensor> units, TriadMember triad) {
  return unit_weights(unit_noise(units, triad));
}

UnitMatrix parity_rows(const UnitVector& noise) {
  const UnitVector inverse = noise.cwiseInverse();
  return parity_noise(noise) * inverse.asDiagonal() * complement(inverse.normalized());
}

double parity_noise(const UnitVector& noise) { return parity_sigma(noise); }

UnitSplit split_errors(const UnitVector& weights, const UnitVector& sigma) {
  const Eigen::Index n = weights.size();
  const UnitVector w = sigma.cwiseProduct(weights);
  const double mean = w.norm();
  if (!(mean > 0)) return {UnitVector::Ones(n), UnitMatrix::Zero(n, n - 1)};
  return {sigma.cwiseProduct(w) / (mean * mean), sigma.asDiagonal() * complement(w / mean) / parity_sigma(sigma)};
}

double parity_sigma(const UnitVector& sigma) {
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

UnitVector unit_noise(std::span<const ImuSensor> units, TriadMember triad) {
  UnitVector out(static_cast<Eigen::Index>(units.size()));
  for (std::size_t i = 0; i < units.size(); ++i) out(static_cast<Eigen::Index>(i)) = (units[i].*triad).noise;
  return out;
}

UnitVector unit_sigmas(std::span<const ImuSensor> units, TriadMember triad, UnitError error) {
  UnitVector out(static_cast<Eigen::Index>(units.size()));
  for (std::size_t i = 0; i < units.size(); ++i) {
    const TriadErrors& unit = units[i].*triad;
    const bool walks = unit.drift.kind == DriftProcess::Kind::kRandomWalk;
    const bool varies = unit.drift.kind == DriftProcess::Kind::kGaussMarkov;
    const double drift = walks ? unit.drift.density : varies ? unit.drift.sigma : 0;
    out(static_cast<Eigen::Index>(i)) = error == UnitError::kBias    ? unit.bias
                                        : error == UnitError::kScale ? unit.scale
                                                                     : drift;
  }
  return out;
}

DriftProcess parity_drift(std::span<const ImuSensor> units, TriadMember triad) {
  using Kind = DriftProcess::Kind;
  const UnitVector sigma = unit_sigmas(units, triad, UnitError::kDrift);
  DriftProcess out;
  double time = 0;
  for (std::size_t i = 0; i < units.size(); ++i) {
    const DriftProcess& drift = (units[i].*triad).drift;
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

ImuSensor mean_sensor(std::span<const ImuSensor> units) {
  ImuSensor out = units.front();
  out.gyro = mean_triad(units, &ImuSensor::gyro);
  out.accel = mean_triad(units, &ImuSensor::accel);
  return out;
}

}  // namespace piste
