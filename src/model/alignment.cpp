#include "piste/model/alignment.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <vector>

#include "piste/math/wahba.h"
#include "vector_pairs.h"

namespace piste {
namespace {

Matrix3d best_rotation(std::span<const VectorPair> pairs) {
  Matrix3d B = Matrix3d::Zero();
  for (const VectorPair& p : pairs) B += p.beta * p.alpha.transpose() / (p.sigma * p.sigma);
  return solve_wahba(B).R;
}

// Covariance of the rotation vector in w. All noise is taken to be that of the fixes, and to be no smaller than they
// state. nullopt if the pairs do not determine every direction.
std::optional<Matrix3d> covariance_of(const Matrix3d& R, std::span<const VectorPair> pairs) {
  Matrix3d information = Matrix3d::Zero();
  double chi2 = 0, rows = 0;
  for (const VectorPair& p : pairs) {
    const Vector3d a = R * p.alpha;
    const double w = 1 / (p.sigma * p.sigma);
    information += w * (a.squaredNorm() * Matrix3d::Identity() - a * a.transpose());
    chi2 += w * (p.beta - a).squaredNorm();
    rows += 3;
  }
  const Eigen::FullPivLU<Matrix3d> lu(information);
  if (!lu.isInvertible()) return std::nullopt;
  return std::max(1.0, chi2 / rows) * lu.inverse();
}

// Velocity at the first fix, from the vectors after the rotation: the mean of the velocities, or the slope of the
// positions.
Vector3d initial_velocity(const Matrix3d& R, const WindowPairs& pairs) {
  if (pairs.velocity.empty()) {
    const VectorPair &a = pairs.position.front(), &b = pairs.position.back();
    return ((b.beta - R * b.alpha) - (a.beta - R * a.alpha)) / (b.time - a.time);
  }
  Vector3d sum = Vector3d::Zero();
  for (const VectorPair& p : pairs.velocity) sum += p.beta - R * p.alpha;
  return sum / static_cast<double>(pairs.velocity.size());
}

// Position at the first fix, in the same way. @pre positions were used
Vector3d initial_position(const Matrix3d& R, const Vector3d& v_wb, const std::vector<VectorPair>& position) {
  Vector3d sum = Vector3d::Zero();
  for (const VectorPair& p : position) sum += p.beta - R * p.alpha - p.time * v_wb;
  return sum / static_cast<double>(position.size());
}

}  // namespace

Quaterniond level(const Vector3d& mean_force, double heading) {
  const double roll = std::atan2(-mean_force.y(), -mean_force.z());
  const double pitch = std::atan2(mean_force.x(), std::hypot(mean_force.y(), mean_force.z()));
  return from_euler({roll, pitch, heading});
}

std::optional<MotionAlignment> align_in_motion(std::span<const ImuSample> imu, std::span<const GnssFix> fixes,
                                               const GnssOptions& receiver, const GyroBias& bias,
                                               const Vector3d& gravity) {
  constexpr std::size_t kFewest = 4;
  if (fixes.size() < kFewest) return std::nullopt;
  const auto raw = pairs_of(imu, fixes, receiver, bias, gravity);
  if (!raw || raw->velocity.size() + raw->position.size() < kFewest) return std::nullopt;

  std::vector<VectorPair> pairs = projected_out(raw->velocity, false);
  const std::vector<VectorPair> positions = projected_out(raw->position, true);
  pairs.insert(pairs.end(), positions.begin(), positions.end());
  const Matrix3d R = best_rotation(pairs);
  const auto covariance = covariance_of(R, pairs);
  if (!covariance) return std::nullopt;

  MotionAlignment result;
  result.time = fixes.front().time;
  result.q_wb = Quaterniond(R).normalized();
  const double turned = 0.5 * bias.sigma * (fixes.back().time - result.time);
  result.covariance = *covariance + turned * turned * Matrix3d::Identity();
  result.v_wb = initial_velocity(R, *raw);
  result.p_wb = raw->position.empty() ? fixes.front().position - R * receiver.lever_arm
                                      : initial_position(R, result.v_wb, raw->position);
  return result;
}

}  // namespace piste
