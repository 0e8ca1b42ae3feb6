#include "start/first_motion.h"

#include <algorithm>
#include <cmath>

#include "core/time_search.h"
#include "piste/math/statistics.h"

namespace piste {
namespace {

// Normal equations of one axis for (position, velocity, acceleration).
struct Normal {
  Matrix3d information = Matrix3d::Zero();
  Vector3d right = Vector3d::Zero();
  double squares = 0, count = 0;

  void add(const Vector3d& row, double value, double variance) {
    information += row * row.transpose() / variance;
    right += row * value / variance;
    squares += value * value / variance;
    count += 1;
  }
};

}  // namespace

Vector3d FirstMotion::sigma(int quantity) const {
  return Vector3d(covariance[0](quantity, quantity), covariance[1](quantity, quantity),
                  covariance[2](quantity, quantity))
      .cwiseSqrt();
}

FixPlace past_outliers(const std::vector<GnssFix>& fixes, FixPlace first, double fastest) {
  const auto agree = [fastest](const GnssFix& a, const GnssFix& b) {
    return (b.position - a.position).norm() <
           fastest * (b.time - a.time) + 5 * (a.sigma_position + b.sigma_position).norm();
  };
  while (fixes.end() - first > 2 && !agree(first[0], first[1]) && agree(first[1], first[2])) ++first;
  return first;
}

FirstMotion first_motion(const World& world, const std::vector<GnssFix>& fixes, const GnssOptions& options, double time,
                         const StartOptions& start) {
  const std::ptrdiff_t fewest = start.fewest;
  const double wander = 2 * square(start.acceleration);  // m²/s⁵: Gauss-Markov acceleration, correlation time 1 s
  auto first = first_at_or_after(fixes, time);
  if (fixes.end() - first < fewest) first = fixes.end() - std::min(std::ssize(fixes), fewest);
  first = past_outliers(fixes, first, start.fastest);
  std::array<Normal, 3> normals;
  const Vector3d origin = first->position;
  const Matrix3d R_wn = world.rotation_wn(origin), R_nw = R_wn.transpose();
  const double latest = time + start.reach + std::max({0.0, options.delay, options.delay_of_velocity()});
  for (auto fix = first; fix != fixes.end() && (fix - first < fewest || fix->time <= latest); ++fix) {
    // Each at its time of validity.
    const double t = fix->time - options.delay - time, v = fix->time - options.delay_of_velocity() - time;
    const double later_position = wander * std::pow(std::abs(t), 5) / 20;
    const double later_velocity = wander * std::pow(std::abs(v), 3) / 3;
    const Vector3d position = R_nw * (fix->position - origin);
    const Vector3d velocity = fix->velocity ? Vector3d(R_nw * fix->velocity->value) : Vector3d::Zero();
    for (int axis = 0; axis < 3; ++axis) {
      Normal& n = normals[static_cast<std::size_t>(axis)];
      n.add({1, t, t * t / 2}, position(axis), square(fix->sigma_position(axis)) + later_position);
      if (fix->velocity && options.use_velocity && std::isfinite(fix->velocity->sigma(axis))) {
        n.add({0, 1, v}, velocity(axis), square(fix->velocity->sigma(axis)) + later_velocity);
      }
    }
  }
  FirstMotion motion{.R_wn = R_wn, .position = {}, .velocity = {}, .acceleration = {}, .covariance = {}};
  for (int axis = 0; axis < 3; ++axis) {
    Normal& n = normals[static_cast<std::size_t>(axis)];
    n.information.diagonal() += Vector3d(0, 1 / square(start.any_speed), 1 / square(start.acceleration));
    Matrix3d& covariance = motion.covariance[static_cast<std::size_t>(axis)];
    covariance = n.information.inverse();
    const Vector3d found = covariance * n.right;
    covariance *= std::max(1.0, (n.squares - found.dot(n.right)) / n.count);
    motion.position(axis) = found(0);
    motion.velocity(axis) = found(1);
    motion.acceleration(axis) = found(2);
  }
  motion.position = origin + R_wn * motion.position;
  motion.velocity = R_wn * motion.velocity;
  motion.acceleration = R_wn * motion.acceleration;
  return motion;
}

}  // namespace piste
