#pragma once
/// A ride that never ends, with the logs of an IMU and a receiver, row by row: nothing of it is stored.

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <numbers>
#include <optional>

#include "piste/live/live.h"
#include "piste/math/units.h"
#include "piste/sim/scenario.h"
#include "support/places.h"
#include "support/random.h"

namespace piste::test {

/// A number that the environment states.
inline double stated(const char* name, double unless) {
  const char* value = std::getenv(name);
  return value != nullptr ? std::atof(value) : unless;
}

/// Half a minute of rest, then round a circle of 80 m for ever, rolling and pitching. All is a function of an inner
/// time u that begins to run smoothly.
class RoundAndRound {
 public:
  struct State {
    Vector3d position, velocity, acceleration;  // in w
    Quaterniond q_wb;
  };
  State at(double t) const {
    const double ramp = std::clamp((t - kRest) / kRamp, 0.0, 1.0);
    const double u = t < kRest + kRamp ? 0.5 * kRamp * ramp * ramp : t - kRest - 0.5 * kRamp,
                 slope = t < kRest + kRamp ? ramp : 1, change = ramp > 0 && ramp < 1 ? 1 / kRamp : 0;
    const double phi = kTurn * u + kSwing * std::sin(kCycle * u), turn = kTurn + kSwing * kCycle * std::cos(kCycle * u),
                 bend = -kSwing * kCycle * kCycle * std::sin(kCycle * u);
    const Vector3d out(std::cos(phi), std::sin(phi), 0), along(-std::sin(phi), std::cos(phi), 0);
    State s;
    s.position = kRadius * out + Vector3d(0, 0, kHeave * std::sin(kWave * u));
    const Vector3d by_u = kRadius * turn * along + Vector3d(0, 0, kHeave * kWave * std::cos(kWave * u)),
                   by_u2 = kRadius * (bend * along - turn * turn * out) -
                           Vector3d(0, 0, kHeave * kWave * kWave * std::sin(kWave * u));
    s.velocity = slope * by_u;
    s.acceleration = change * by_u + slope * slope * by_u2;
    s.q_wb = from_euler({0.15 * std::sin(0.9 * u), 0.08 * std::sin(0.6 * u),
                         std::remainder(phi, 2 * std::numbers::pi) + std::numbers::pi / 2});
    return s;
  }

 private:
  static constexpr double kRest = 30, kRamp = 8, kRadius = 80, kTurn = 0.12, kSwing = 0.4, kCycle = 0.21, kHeave = 1.5,
                          kWave = 0.13;
};

/// The logs of that ride: an IMU of the ski scenario with instantaneous samples, and a receiver of four fixes a second.
class EndlessRide {
 public:
  static constexpr double kWhite = 0.02;  // of a fix [m]

  EndlessRide(double hertz, std::uint64_t seed) : interval_(1 / hertz), random_(seed) {
    gyro_bias_ = random_.vector(sensor_.gyro.bias), accel_bias_ = random_.vector(sensor_.accel.bias);
    gyro_drift_ = random_.vector(sensor_.gyro.drift.sigma), accel_drift_ = random_.vector(sensor_.accel.drift.sigma);
  }

  const ImuSensor& sensor() const { return sensor_; }
  const World& world() const { return world_; }
  const Vector3d& lever_arm() const { return arm_; }
  Vector3d position(double time) const { return motion_.at(time).position; }

  /// The next row of the IMU.
  ImuRow row() {
    constexpr double kStep = 1e-4;
    time_ = interval_ * static_cast<double>(++rows_);
    const RoundAndRound::State s = motion_.at(time_);
    const Matrix3d R_bw = s.q_wb.conjugate().toRotationMatrix();
    const Vector3d turning =
        so3_log((motion_.at(time_ - kStep).q_wb.conjugate() * motion_.at(time_ + kStep).q_wb).normalized()) /
        (2 * kStep);
    wander(gyro_drift_, sensor_.gyro.drift);
    wander(accel_drift_, sensor_.accel.drift);
    const Vector3d rate = R_bw * world_.earth_rate() + turning,
                   force = R_bw * (s.acceleration + 2 * world_.earth_rate().cross(s.velocity) -
                                   world_.gravity(s.position).value);
    return {time_, rate + gyro_bias_ + gyro_drift_ + random_.vector(sensor_.gyro.noise / std::sqrt(interval_)),
            force + accel_bias_ + accel_drift_ + random_.vector(sensor_.accel.noise / std::sqrt(interval_))};
  }

  /// The fix at the time of the last row, if there is one.
  std::optional<GeodeticFix> fix() {
    if (time_ + 1e-9 < next_fix_) return std::nullopt;
    next_fix_ += kBetweenFixes;
    const RoundAndRound::State s = motion_.at(time_);
    GeodeticFix fix;
    fix.time = time_;
    fix.position = world_.to_geodetic(s.position + s.q_wb * arm_ + random_.vector(kWhite));
    fix.sigma_position.setConstant(kWhite);
    return fix;
  }

 private:
  static constexpr double kBetweenFixes = 0.25;  // s

  void wander(Vector3d& drift, const DriftProcess& process) {
    const double stays = std::exp(-interval_ / process.correlation_time);
    drift = stays * drift + random_.vector(process.sigma * std::sqrt(1 - stays * stays));
  }

  World world_{{46 * kDegree, 7 * kDegree, 1500}};
  ImuSensor sensor_ = read_scenario(kSource / "config/scenarios/ski.yaml").imus.front().sensor;
  Vector3d arm_{0, 0, -0.4};
  RoundAndRound motion_;
  double interval_;
  Random random_;
  Vector3d gyro_bias_, accel_bias_, gyro_drift_, accel_drift_;
  double time_ = 0, next_fix_ = kBetweenFixes;
  std::size_t rows_ = 0;
};

}  // namespace piste::test
