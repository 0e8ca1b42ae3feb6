#include "piste/inspect/vehicle_guess.h"

#include <fmt/format.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <vector>

#include "log_signals.h"
#include "piste/math/statistics.h"
#include "piste/math/units.h"

namespace piste {
namespace {

constexpr double kFast = 5;               // m/s: as find_vehicle_mounting() needs it
constexpr double kMean = 2;               // s over which forces are averaged: an engine and the road shake
constexpr double kLeastDriving = 60;      // s, likewise
constexpr double kTurning = 5 * kDegree;  // rad/s: the course of a receiver tells such turns

// The means over a window of motion in which the body is fast.
struct DrivenWindow {
  Vector3d force, rate;
  double along = 0, across = 0, course_rate = 0;  // accelerations of the track, and its turn rate
};

std::vector<DrivenWindow> driven(const ImuIntegral& imu, const Track& track, double offset) {
  std::vector<DrivenWindow> windows;
  if (track.empty()) return windows;
  const double from = std::max(track.start(), imu.start() - offset), to = std::min(track.end(), imu.end() - offset);
  for (double t = from; t + kMean < to; t += kMean) {
    const auto before = track.velocity(t), after = track.velocity(t + kMean);
    if (!before || !after || !imu.covers(t + offset, t + kMean + offset)) continue;
    const Eigen::Vector2d v0 = before->head<2>(), v1 = after->head<2>();
    if (v0.norm() < kFast || v1.norm() < kFast) continue;
    const ImuIntegral::Value a = imu.at(t + offset), b = imu.at(t + kMean + offset);
    DrivenWindow w;
    w.force = (b.velocity - a.velocity) / kMean;
    w.rate = (b.angle - a.angle) / kMean;
    w.course_rate = std::atan2(v0.x() * v1.y() - v0.y() * v1.x(), v0.dot(v1)) / kMean;
    // Along and across the course in the middle of the window, as the mean force is that of its middle.
    const Eigen::Vector2d course = (v0.normalized() + v1.normalized()).normalized(), change = (v1 - v0) / kMean;
    w.along = course.dot(change);
    w.across = course.x() * change.y() - course.y() * change.x();
    windows.push_back(w);
  }
  return windows;
}

// Bounds of a car. TODO
constexpr double kLeastTurned = 90 * kDegree;

}  // namespace

bool VehicleGuess::is_car() const {
  return driving >= kLeastDriving && std::min(turned_left, turned_right) > kLeastTurned;
}

std::string VehicleGuess::why() const {
  return fmt::format("driving {:.0f} left {:.0f} right {:.0f} along {:.2f} across {:.2f} handed {:.2f} unlike {:.2f} slip {:.2f}",
    driving, turned_left/kDegree, turned_right/kDegree, force_along, force_across, handed, unlike, slip/kDegree);
}

VehicleGuess guess_vehicle(const ImuRecording& imu, const GnssRecording& gnss, const GnssHealth& health,
                           const LogMatch& match) {
  VehicleGuess g;
  if (!match.motion || match.motion->mirrored || !match.motion->as_given() || !match.clock) return g;
  const ImuIntegral integral(imu);
  const Track track(gnss, health);
  const std::vector<DrivenWindow> windows = driven(integral, track, match.clock->offset);
  g.driving = kMean * static_cast<double>(windows.size());
  if (g.driving < kLeastDriving) return g;
  // force = forward · along + right · across + up, by least squares.
  Matrix3d normal = Matrix3d::Zero(), right_side = Matrix3d::Zero();
  for (const DrivenWindow& w : windows) {
    const Vector3d a(w.along, w.across, 1);
    normal += a * a.transpose();
    right_side += w.force * a.transpose();
  }
  const Matrix3d axes = right_side * normal.ldlt().solve(Matrix3d::Identity());
  const Vector3d up = axes.col(2).normalized();
  g.force_along = axes.col(0).norm();
  g.force_across = axes.col(1).norm();
  g.handed = axes.col(0).cross(axes.col(1)).dot(-up) / (g.force_along * g.force_across);
  const Vector3d right = axes.col(1).normalized();
  double unlike = 0, turns = 0;
  std::vector<double> course_less_body;
  for (const DrivenWindow& w : windows) {
    const double felt = right.dot(w.force - axes.col(2));
    unlike += (felt - w.across) * (felt - w.across);
    turns += w.across * w.across;
    (w.course_rate > 0 ? g.turned_right : g.turned_left) += std::abs(w.course_rate) * kMean;
    if (std::abs(w.course_rate) > kTurning) course_less_body.push_back(std::abs(w.course_rate + up.dot(w.rate)) * kMean);
  }
  g.unlike = std::sqrt(unlike / turns);
  if (!course_less_body.empty()) g.slip = median(std::move(course_less_body));
  return g;
}

}  // namespace piste
