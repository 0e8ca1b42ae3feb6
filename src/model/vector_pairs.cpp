#include "vector_pairs.h"

#include <cmath>

namespace piste {
namespace {

// Rotation since the start, and the integrals of the specific force in the body axes of the start.
struct Reckoned {
  Quaterniond C = Quaterniond::Identity();
  Vector3d u = Vector3d::Zero(), s = Vector3d::Zero();

  Reckoned after(double dt, const Vector3d& rate, const Vector3d& force) const {
    const Vector3d f = (C * so3_exp(0.5 * dt * rate)) * force;
    return {C * so3_exp(dt * rate), u + dt * f, s + dt * u + 0.5 * dt * dt * f};
  }
};

double one_axis(const Vector3d& sigma) { return sigma.norm() / std::sqrt(3.0); }

}  // namespace

std::optional<WindowPairs> pairs_of(std::span<const ImuSample> imu, std::span<const GnssFix> fixes,
                                    const GnssOptions& receiver, const GyroBias& bias, const Vector3d& gravity) {
  WindowPairs pairs;
  const double t0 = fixes.front().time;
  Reckoned reckoned;
  double covered = t0;  // dead reckoned up to here
  std::size_t next = 0;
  for (const ImuSample& sample : imu) {
    if (next == fixes.size()) break;
    if (sample.time <= t0) continue;
    if (sample.gap || sample.time - sample.interval > covered + 1e-6) return std::nullopt;
    const Vector3d rate = sample.dtheta / sample.interval - bias.value, force = sample.dvel / sample.interval;
    for (; next < fixes.size() && fixes[next].time <= sample.time; ++next) {
      const GnssFix& fix = fixes[next];
      const double t = fix.time - t0;
      const auto [C, u, s] = reckoned.after(fix.time - covered, rate, force);
      if (receiver.use_position) {
        pairs.position.push_back(
            {t, s + C * receiver.lever_arm, fix.position - 0.5 * t * t * gravity, one_axis(fix.sigma_position)});
      }
      if (receiver.use_velocity && fix.velocity && fix.velocity->has_down()) {
        pairs.velocity.push_back({t, u + C * rate.cross(receiver.lever_arm), fix.velocity->value - t * gravity,
                                  one_axis(fix.velocity->sigma)});
      }
    }
    reckoned = reckoned.after(sample.time - covered, rate, force);
    covered = sample.time;
  }
  if (next < fixes.size()) return std::nullopt;
  return pairs;
}

std::vector<VectorPair> projected_out(std::vector<VectorPair> pairs, bool lines) {
  double w0 = 0, w1 = 0, w2 = 0;
  Vector3d a0 = Vector3d::Zero(), a1 = a0, b0 = a0, b1 = a0;
  for (const VectorPair& p : pairs) {
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
  for (VectorPair& p : pairs) {
    const double t = p.time - mean;
    p.alpha -= a0 / w0;
    p.beta -= b0 / w0;
    if (!lines) continue;
    p.alpha -= t / spread * (a1 - mean * a0);
    p.beta -= t / spread * (b1 - mean * b0);
  }
  return pairs;
}

}  // namespace piste
