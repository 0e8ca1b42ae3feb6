#include "piste/model/alignment.h"

#include <Eigen/LU>
#include <Eigen/SVD>
#include <algorithm>
#include <cmath>
#include <vector>

namespace piste {

Quaterniond level(const Vector3d& mean_force, double heading) {
  const double roll = std::atan2(-mean_force.y(), -mean_force.z());
  const double pitch = std::atan2(mean_force.x(), std::hypot(mean_force.y(), mean_force.z()));
  return from_euler({roll, pitch, heading});
}

namespace {

// One vector seen from both sides, and the 1-sigma of its noise.
struct Pair {
  double time;
  Vector3d alpha, beta;
  double sigma;
};

// Weighted projection of constants, and of lines where `lines`, out of both sides.
void project_out(std::vector<Pair>& pairs, bool lines) {
  double w0 = 0, w1 = 0, w2 = 0;
  Vector3d a0 = Vector3d::Zero(), a1 = a0, b0 = a0, b1 = a0;
  for (const Pair& p : pairs) {
    const double w = 1 / (p.sigma * p.sigma);
    w0 += w;
    w1 += w * p.time;
    w2 += w * p.time * p.time;
    a0 += w * p.alpha;
    a1 += w * p.time * p.alpha;
    b0 += w * p.beta;
    b1 += w * p.time * p.beta;
  }
  const double mean = w1 / w0, spread = w2 - w1 * mean;
  for (Pair& p : pairs) {
    const double t = p.time - mean;
    p.alpha -= a0 / w0;
    p.beta -= b0 / w0;
    if (!lines) continue;
    p.alpha -= t / spread * (a1 - mean * a0);
    p.beta -= t / spread * (b1 - mean * b0);
  }
}

}  // namespace

std::optional<MotionAlignment> align_in_motion(std::span<const ImuSample> imu, std::span<const GnssFix> fixes,
                                               const GnssOptions& receiver, const GyroBias& bias,
                                               const Vector3d& gravity) {
  if (fixes.size() < 4) return std::nullopt;
  const double t0 = fixes.front().time;
  std::vector<Pair> velocity, position;
  Quaterniond C = Quaterniond::Identity();
  Vector3d u = Vector3d::Zero(), s = Vector3d::Zero();
  std::size_t next = 0;
  double covered = t0;  // dead reckoned up to here
  for (const ImuSample& sample : imu) {
    const double begin = sample.time - sample.interval;
    if (sample.time <= t0) continue;
    if (sample.gap || begin > covered + 1e-6) return std::nullopt;
    const Vector3d rate = sample.dtheta / sample.interval - bias.value, force = sample.dvel / sample.interval;
    const auto reckon = [&](double dt, Quaterniond& q, Vector3d& du, Vector3d& ds) {
      q = C * so3_exp(dt * rate);
      const Vector3d f = (C * so3_exp(0.5 * dt * rate)) * force;
      du = u + dt * f;
      ds = s + dt * u + 0.5 * dt * dt * f;
    };
    Quaterniond q;
    Vector3d du, ds;
    for (; next < fixes.size() && fixes[next].time <= sample.time; ++next) {
      const GnssFix& fix = fixes[next];
      const double t = fix.time - t0;
      reckon(fix.time - covered, q, du, ds);
      if (receiver.use_position) {
        position.push_back({t, ds + q * receiver.lever_arm, fix.position - 0.5 * t * t * gravity,
                            fix.sigma_position.norm() / std::sqrt(3.0)});
      }
      if (receiver.use_velocity && fix.velocity && fix.velocity->has_down()) {
        velocity.push_back({t, du + q * rate.cross(receiver.lever_arm), fix.velocity->value - t * gravity,
                            fix.velocity->sigma.norm() / std::sqrt(3.0)});
      }
    }
    reckon(sample.time - covered, q, du, ds);
    C = q;
    u = du;
    s = ds;
    covered = sample.time;
    if (next == fixes.size()) break;
  }
  if (next < fixes.size() || velocity.size() + position.size() < 4) return std::nullopt;

  const std::vector<Pair> raw_velocity = velocity, raw_position = position;
  project_out(velocity, false);
  project_out(position, true);
  Matrix3d B = Matrix3d::Zero();
  const auto each = [&](auto&& f) {
    for (const auto* pairs : {&velocity, &position}) {
      for (const Pair& p : *pairs) f(p);
    }
  };
  each([&](const Pair& p) { B += p.beta * p.alpha.transpose() / (p.sigma * p.sigma); });
  const Eigen::JacobiSVD<Matrix3d> svd(B, Eigen::ComputeFullU | Eigen::ComputeFullV);
  const double sign = (svd.matrixU() * svd.matrixV().transpose()).determinant() > 0 ? 1 : -1;
  const Matrix3d R = svd.matrixU() * Vector3d(1, 1, sign).asDiagonal() * svd.matrixV().transpose();

  Matrix3d information = Matrix3d::Zero();
  double chi2 = 0, rows = 0;
  each([&](const Pair& p) {
    const Vector3d a = R * p.alpha;
    const double w = 1 / (p.sigma * p.sigma);
    information += w * (a.squaredNorm() * Matrix3d::Identity() - a * a.transpose());
    chi2 += w * (p.beta - a).squaredNorm();
    rows += 3;
  });
  const Eigen::FullPivLU<Matrix3d> lu(information);
  if (!lu.isInvertible()) return std::nullopt;
  MotionAlignment result;
  result.time = t0;
  result.q_wb = Quaterniond(R).normalized();
  const double turned = 0.5 * bias.sigma * (fixes.back().time - t0);
  result.covariance = std::max(1.0, chi2 / rows) * lu.inverse() + turned * turned * Matrix3d::Identity();

  // v₀ and p₀ from what the rotation leaves.
  Vector3d v = Vector3d::Zero(), p = Vector3d::Zero();
  if (!raw_velocity.empty()) {
    for (const Pair& k : raw_velocity) v += k.beta - R * k.alpha;
    v /= static_cast<double>(raw_velocity.size());
  } else {
    const Pair &a = raw_position.front(), &b = raw_position.back();
    v = ((b.beta - R * b.alpha) - (a.beta - R * a.alpha)) / (b.time - a.time);
  }
  if (raw_position.empty()) {
    p = fixes.front().position - R * receiver.lever_arm;
  } else {
    for (const Pair& k : raw_position) p += k.beta - R * k.alpha - k.time * v;
    p /= static_cast<double>(raw_position.size());
  }
  result.v_wb = v;
  result.p_wb = p;
  return result;
}

}  // namespace piste
