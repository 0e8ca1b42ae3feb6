#pragma once
/// A wild motion with exactly known values, and sensors on it.

#include <array>
#include <cmath>
#include <vector>

#include "piste/core/log.h"

namespace piste::test {

/// Turns and swings as sums of sines. The body stands still until `begin`, and moves off smoothly.
struct WildMotion {
  World world{{0.8116, 0.1222, 900}};
  double begin = -10;
  double heading = 0.7;  ///< mean heading of the swings [rad]

  struct State {
    Quaterniond q_wb;
    Vector3d p_wb, v_wb, w_ib_b, f_ib_b;
  };

  State at(double time) const {
    const double s = std::max(time - begin, 0.0), u = s * s + 1;
    const double tau = s - s / u, d = 1 - (1 - s * s) / (u * u), dd = (6 * s - 2 * s * s * s) / (u * u * u);
    Vector3d euler(0.1, -0.2, heading), euler_rate = Vector3d::Zero();
    Vector3d p = Vector3d::Zero(), p1 = Vector3d(8, 3, 1), p2 = Vector3d::Zero();
    p += tau * p1;
    for (const Swing& w : kSwings) {
      const double phase = 2 * kPi * w.frequency * tau, rate = 2 * kPi * w.frequency;
      euler += w.angle * std::sin(phase);
      euler_rate += w.angle * (rate * std::cos(phase));
      p += w.place * (1 - std::cos(phase));
      p1 += w.place * (rate * std::sin(phase));
      p2 += w.place * (rate * rate * std::cos(phase));
    }
    State x;
    x.q_wb = from_euler(euler);
    x.p_wb = p;
    x.v_wb = p1 * d;
    const Vector3d a = p2 * (d * d) + p1 * dd, earth = world.earth_rate();
    const Matrix3d R_bw = x.q_wb.toRotationMatrix().transpose();
    x.w_ib_b = R_bw * (earth + euler_axes(euler) * euler_rate * d);
    x.f_ib_b = R_bw * (a - gravity_.at(x.p_wb) + 2 * earth.cross(x.v_wb));
    return x;
  }

  /// Increments over (start, end]: Gauss-Legendre of tenth order on four pieces, exact to rounding.
  ImuSample sample(double start, double end) const {
    constexpr std::array<double, 5> node{-0.9061798459386640, -0.5384693101056831, 0, 0.5384693101056831,
                                         0.9061798459386640};
    constexpr std::array<double, 5> weight{0.2369268850561891, 0.4786286704993665, 0.5688888888888889,
                                           0.4786286704993665, 0.2369268850561891};
    ImuSample s;
    s.time = end;
    s.interval = end - start;
    s.at_rest = end < begin;
    const double half = (end - start) / 8;
    for (int piece = 0; piece < 4; ++piece) {
      for (std::size_t i = 0; i < node.size(); ++i) {
        const State x = at(start + half * (2 * piece + 1 + node[i]));
        s.dtheta += half * weight[i] * x.w_ib_b;
        s.dvel += half * weight[i] * x.f_ib_b;
      }
    }
    return s;
  }

  std::vector<ImuSample> samples(double start, double end, double dt) const {
    std::vector<ImuSample> all;
    const int count = static_cast<int>(std::lround((end - start) / dt));
    for (int i = 0; i < count; ++i) all.push_back(sample(start + i * dt, start + (i + 1) * dt));
    return all;
  }

  /// Position and velocity of an antenna, without errors.
  GnssFix fix(double time, const Vector3d& lever_arm, const Vector3d& sigma_position = {0.02, 0.02, 0.03}) const {
    const State x = at(time);
    const Vector3d arm = x.q_wb * lever_arm;
    const Vector3d swing = x.q_wb * x.w_ib_b.cross(lever_arm) - world.earth_rate().cross(arm);
    return {time, x.p_wb + arm, sigma_position, FixVelocity{x.v_wb + swing, {0.03, 0.03, 0.05}}};
  }

  const Gravity& gravity() const { return gravity_; }

 private:
  static constexpr double kPi = 3.14159265358979323846;
  struct Swing {
    double frequency;
    Vector3d angle, place;
  };
  // The turns, and a vibration with coning and sculling.
  inline static const std::array<Swing, 3> kSwings{
      Swing{0.4, {0.6, 0.2, 0.9}, {1.5, 3.0, 0.4}},
      Swing{1.7, {0.10, 0.25, 0.15}, {0.10, -0.05, 0.12}},
      Swing{6.0, {0.02, -0.03, 0.02}, {0.002, 0.003, -0.003}},
  };
  // Linear over the range of the motion: exactly the gravity of this world.
  Gravity gravity_ = world.gravity(Vector3d::Zero());
};

}  // namespace piste::test
