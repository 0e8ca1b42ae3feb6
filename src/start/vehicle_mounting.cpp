#include "start/vehicle_mounting.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "filter/feeder.h"
#include "piste/core/error.h"
#include "piste/math/statistics.h"

namespace piste {
namespace {

constexpr double kDriving = 5;              // m/s: at lower speeds, turns on the spot and slopes have a larger effect
constexpr double kSlip = 1 * kDegree;       // 1-sigma of the direction of a single velocity, by slip and suspension
constexpr double kVelocityEvery = 0.5;      // s between two velocities that are used
constexpr double kEnough = 60;              // s of driving: several turns, slopes and loads of the suspension
constexpr double kAlike = 10;               // s over which the filter's error in direction is nearly constant
constexpr double kKnown = 10 * kDegree;     // largest 1-sigma of a result
constexpr double kCrossfall = 2 * kDegree;  // 1-sigma of roll: roads have a crossfall
constexpr double kLoose = 2;                // times the sigmas, as the filter uses the same motion again

// The mean direction of the velocity in the body so far.
struct Direction {
  Vector3d forward = Vector3d::Zero(), down = Vector3d::Zero();
  double weight = 0, square = 0, forth = 0, back = 0, time = 0;

  void add(const Vector3d& v_b, const Vector3d& down_b, double variance) {
    const double speed = v_b.norm(), w = 1 / (variance + kSlip * kSlip);
    Vector3d along = v_b / speed;
    const bool reverse = weight > 0 && along.dot(forward) < 0;
    if (reverse) along = -along;
    (reverse ? back : forth) += speed;
    forward += w * along;
    down += w * down_b;
    weight += w;
    square += w * w * (variance + kSlip * kSlip);
    time += kVelocityEvery;
  }
  // Neighbouring velocities share the error of the filter.
  double sigma() const { return std::sqrt(square * kAlike / kVelocityEvery) / weight; }
};

}  // namespace

FilterOptions without_vehicle(FilterOptions options) {
  options.vehicle.reset();
  options.odometer.reset();
  std::erase_if(options.estimate, [&](Block b) { return info(b).implied && !has_error(options, b); });
  return options;
}

std::optional<VehicleMounting> find_vehicle_mounting(const Log& log, const FilterOptions& options, const Start& start) {
  Start plain = start;
  plain.covariance = plain.covariance.topLeftCorner(9, 9).eval();
  Filter filter(without_vehicle(options), log.world, plain);
  Feeder feeder(log, place_at(log, start.time, {}), filter);
  Direction d;
  double next = start.time;
  while (!feeder.done() && !(d.time >= kEnough && d.sigma() < kSlip)) {
    if (!feeder.step()) continue;
    filter.clear_innovations();
    if (filter.time() < next) continue;
    next = filter.time() + kVelocityEvery;
    const Estimate& x = filter.estimate();
    const double speed = x.v_wb.norm();
    if (speed < kDriving) continue;
    // Across the velocity the error has two axes: the mean of their variances counts.
    const Matrix3d P = filter.covariance().block<3, 3>(3, 3);
    const Vector3d along = x.v_wb / speed;
    const double variance = 0.5 * (P.trace() - along.dot(P * along)) / (speed * speed);
    if (variance > kKnown * kKnown) continue;
    const Matrix3d R_bw = x.R_wb().transpose();
    d.add(R_bw * x.v_wb, R_bw * log.world.rotation_wn(x.p_wb).col(2), variance);
  }
  if (!(d.weight > 0) || !(d.sigma() < kKnown)) return std::nullopt;
  Vector3d forward = d.forward.normalized();
  if (d.back > d.forth) forward = -forward;
  Vector3d right = d.down.cross(forward);
  if (right.norm() < 0.5 * d.weight) return std::nullopt;  // the velocity is nearly vertical
  right.normalize();
  Matrix3d R_vb;
  R_vb << forward.transpose(), right.transpose(), forward.cross(right).transpose();
  return VehicleMounting{
      Quaterniond(R_vb), {kCrossfall, d.sigma(), d.sigma()}, std::max(d.forth, d.back) / (d.forth + d.back)};
}

FilterOptions with_mounting(FilterOptions options, const Log& log, Start& start) {
  if (!options.vehicle) return options;
  VehicleOptions& vehicle = *options.vehicle;
  if (!vehicle.mounting) {
    const std::optional<VehicleMounting> found = find_vehicle_mounting(log, options, start);
    if (!found) {
      throw DataError("vehicle",
                      "`mounting: auto` finds no mounting: the log has too little driving faster than 5 m/s with GNSS; "
                      "state it, such as `mounting: 0 0 0 deg`, or leave `vehicle` out");
    }
    vehicle.mounting = found->q_vb;
    vehicle.mounting_sigma = (kLoose * found->sigma).cwiseMax(kSlip);
  }
  set_known(start.x, options);
  return options;
}

}  // namespace piste
