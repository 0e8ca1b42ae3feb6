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

constexpr double kFast = 5;                     // m/s: the speed that find_vehicle_mounting() needs
constexpr double kMean = 2;                     // s over which forces are averaged, because engine and road shake
constexpr double kLeastDriving = 120;           // s: mounting needs 60 s, which must remain after an outage
constexpr double kLeastFitted = 20;             // s: least time for a meaningful fit
constexpr double kTurningCourse = 5 * kDegree;  // rad/s: turns that a receiver's course shows

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
    // Along and across the course in the middle of the window, where the mean force applies.
    const Eigen::Vector2d course = (v0.normalized() + v1.normalized()).normalized(), change = (v1 - v0) / kMean;
    w.along = course.dot(change);
    w.across = course.x() * change.y() - course.y() * change.x();
    windows.push_back(w);
  }
  return windows;
}

}  // namespace

bool VehicleGuess::is_car() const {
  // A car body rolls outwards on its springs, by up to a tenth of the force. Velocities that a receiver smooths or
  // delays may miss a third of a turn. A body that leans feels less than half of the force.
  constexpr double kLeastGain = 0.6, kMostGain = 1.3, kUnlike = 0.55;
  constexpr double kUpright = 0.95;          // the fitted axes are right-handed and perpendicular to 18 deg
  constexpr double kPointing = 3 * kDegree;  // accuracy of a receiver's course
  constexpr double kTurned = 90 * kDegree;   // each way: the bend of a runway or a slope does not suffice
  const auto felt = [&](double part) { return part > kLeastGain && part < kMostGain; };
  return driving >= kLeastDriving && std::min(turned_left, turned_right) > kTurned && felt(force_along) &&
         felt(force_across) && handed > kUpright && unlike < kUnlike && slip < kPointing;
}

std::string VehicleGuess::why() const {
  return fmt::format(
      "in {:.0f} s faster than 5 m/s it turned {:.0f} deg left and {:.0f} deg right without leaning: the IMU felt "
      "{:.2f} of "
      "the acceleration along the track and {:.2f} of that across it; in turns it points along the track to {:.1f} deg",
      driving, turned_left / kDegree, turned_right / kDegree, force_along, force_across, slip / kDegree);
}

VehicleGuess guess_vehicle(const ImuRecording& imu, const GnssRecording& gnss, const GnssHealth& health,
                           const LogMatch& match) {
  VehicleGuess g;
  if (!match.motion || match.motion->mirrored || !match.motion->as_given() || !match.clock) return g;
  const ImuIntegral integral(imu);
  const Track track(gnss, health);
  const std::vector<DrivenWindow> windows = driven(integral, track, match.clock->offset);
  g.driving = kMean * static_cast<double>(windows.size());
  if (g.driving < kLeastFitted) return g;
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
    if (std::abs(w.course_rate) > kTurningCourse)
      course_less_body.push_back(std::abs(w.course_rate + up.dot(w.rate)) * kMean);
  }
  g.unlike = std::sqrt(unlike / turns);
  if (!course_less_body.empty()) g.slip = median(std::move(course_less_body));
  return g;
}

}  // namespace piste
