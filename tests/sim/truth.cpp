#include "piste/sim/truth.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "piste/math/units.h"

namespace piste {
namespace {

MotionOptions lively() {
  MotionOptions motion;
  motion.rest_before = 20;
  motion.run = 40;
  motion.rest_after = 10;
  motion.speed = 16;
  motion.cycle = 3.5;
  motion.turn = 0.6;
  motion.net_turn = 1.5;
  motion.heading = 2.1;
  motion.lean = 0.8;
  motion.balance_rate = Vector3d::Constant(0.05);
  motion.vibration = {1, 1, 2};
  motion.vibration_rate = Vector3d::Constant(0.1);
  return motion;
}

// An IMU that is turned and off the trunk's point, so that every term matters.
Truth imu_truth(const MotionOptions& motion) {
  const World world(Geodetic{46.1 * kDegree, 7.2 * kDegree, 2000});
  return Truth(world, motion, 7, 1000).attached(from_euler({0.1, -0.7, 0.2}), {0.1, -0.2, 0.3});
}

// Fourth-order central difference.
template <class F>
auto difference(F f, double t) {
  constexpr double h = 1e-3;
  return ((f(t - 2 * h) - 8 * f(t - h) + 8 * f(t + h) - f(t + 2 * h)) / (12 * h)).eval();
}

TEST(Truth, DerivativesAgreeWithDifferences) {
  const Truth truth = imu_truth(lively());
  // At rest, while starting, under way, while stopping.
  for (const double t : {1005.0, 1021.3, 1024.9, 1033.0, 1041.7, 1058.2, 1065.0}) {
    const TruthState s = truth.at(t);
    const Vector3d v = difference([&](double x) { return truth.at(x).p_wb; }, t);
    const Vector3d a = difference([&](double x) { return truth.at(x).v_wb; }, t);
    const Vector3d w_dot = difference([&](double x) { return truth.at(x).w_ib_b; }, t);
    const Vector3d w_wb_b = difference([&](double x) { return so3_log(s.q_wb.conjugate() * truth.at(x).q_wb); }, t);
    EXPECT_LT((v - s.v_wb).norm(), 1e-7) << t;
    EXPECT_LT((a - s.acceleration).norm(), 1e-6) << t;
    EXPECT_LT((w_dot - s.w_ib_b_dot).norm(), 1e-5) << t;
    const Vector3d w_ib_b = w_wb_b + s.q_wb.conjugate() * truth.world().earth_rate();
    EXPECT_LT((w_ib_b - s.w_ib_b).norm(), 1e-6) << t;
  }
}

// Mechanization in the world frame by classical Runge-Kutta, with gravity taken anew at every stage.
struct Nav {
  Eigen::Vector4d q;  // w, x, y, z
  Vector3d v, p;
  Nav plus(const Nav& d, double h) const { return {q + h * d.q, v + h * d.v, p + h * d.p}; }
};

Nav rate_of(const Nav& x, const TruthState& s, const World& world) {
  const Quaterniond q(x.q(0), x.q(1), x.q(2), x.q(3));
  const Vector3d w = s.w_ib_b - q.normalized().conjugate() * world.earth_rate();
  const Quaterniond dq = q * Quaterniond(0, w.x() / 2, w.y() / 2, w.z() / 2);
  const Vector3d g = world.gravity(x.p).value;
  return {{dq.w(), dq.x(), dq.y(), dq.z()}, q.normalized() * s.f_ib_b + g - 2 * world.earth_rate().cross(x.v), x.v};
}

TEST(Truth, IntegratesToItself) {
  const Truth truth = imu_truth(lively());
  const World& world = truth.world();
  const double h = 2e-3, start = 1010;
  const TruthState first = truth.at(start);
  Nav x{{first.q_wb.w(), first.q_wb.x(), first.q_wb.y(), first.q_wb.z()}, first.v_wb, first.p_wb};
  const int steps = 22500;  // 45 s: rest, start, run
  for (int k = 0; k < steps; ++k) {
    const double t = start + k * h;
    const TruthState a = truth.at(t), b = truth.at(t + h / 2), c = truth.at(t + h);
    const Nav k1 = rate_of(x, a, world), k2 = rate_of(x.plus(k1, h / 2), b, world);
    const Nav k3 = rate_of(x.plus(k2, h / 2), b, world), k4 = rate_of(x.plus(k3, h), c, world);
    x = x.plus(k1, h / 6).plus(k2, h / 3).plus(k3, h / 3).plus(k4, h / 6);
    x.q.normalize();
  }
  const TruthState last = truth.at(start + steps * h);
  EXPECT_GT((last.p_wb - first.p_wb).norm(), 300);
  EXPECT_LT((x.p - last.p_wb).norm(), 2e-5);
  EXPECT_LT((x.v - last.v_wb).norm(), 2e-6);
  const Quaterniond q(x.q(0), x.q(1), x.q(2), x.q(3));
  EXPECT_LT(so3_log(q.conjugate() * last.q_wb).norm(), 1e-8);
}

TEST(Truth, MeanIsTheIntegralOverTheInterval) {
  const Truth truth = imu_truth(lively());
  const MeanInertial whole = truth.mean(1030, 1030.01);
  Vector3d gyro = Vector3d::Zero(), accel = Vector3d::Zero();
  constexpr int kParts = 400;
  for (int i = 0; i < kParts; ++i) {
    const TruthState s = truth.at(1030 + 0.01 * (i + 0.5) / kParts);
    gyro += s.w_ib_b / kParts;
    accel += s.f_ib_b / kParts;
  }
  EXPECT_LT((whole.gyro - gyro).norm(), 1e-6);
  EXPECT_LT((whole.accel - accel).norm(), 1e-6);
}

TEST(Truth, RestIsAtRestButForSway) {
  MotionOptions motion = lively();
  motion.sway_velocity.setZero();
  motion.sway_rate.setZero();
  motion.turning_rate = 0;
  const Truth still = imu_truth(motion);
  for (const double t : {1000.0, 1019.9, 1060.1, 1069.0}) {
    const TruthState s = still.at(t);
    EXPECT_LT(s.v_wb.norm(), 1e-12);
    EXPECT_NEAR(s.w_ib_b.norm(), kEarthRate, 1e-12);
    EXPECT_LT((s.q_wb * s.f_ib_b + still.world().gravity(s.p_wb).value).norm(), 1e-9);
  }

  const Truth swaying = imu_truth(lively());
  double velocity = 0, rate = 0;
  constexpr int kSamples = 1900;
  for (int i = 0; i < kSamples; ++i) {
    const TruthState s = swaying.at(1000 + 0.01 * i);
    velocity += s.v_wb.squaredNorm() / (3 * kSamples);
    rate += s.w_ib_b.squaredNorm() / (3 * kSamples);
  }
  EXPECT_GT(std::sqrt(velocity), 0.002);
  EXPECT_LT(std::sqrt(velocity), 0.01);
  EXPECT_LT(std::sqrt(rate), 0.3 * kDegree);
}

TEST(Truth, StartsAtTheOriginWithItsHeading) {
  MotionOptions motion = lively();
  motion.sway_velocity.setZero();
  motion.sway_rate.setZero();
  motion.turning_rate = 0;
  const World world(Geodetic{46.1 * kDegree, 7.2 * kDegree, 2000});
  const TruthState s = Truth(world, motion, 3, 1000).at(1000);
  EXPECT_LT(s.p_wb.norm(), 1e-9);
  EXPECT_LT((to_euler(s.q_wb) - Vector3d(0, 0, motion.heading)).norm(), 1e-9);
}

TEST(Truth, LapTurnsOnceAndComesBack) {
  MotionOptions motion = lively();
  motion.net_turn = 2 * std::numbers::pi;
  motion.turn = 0;
  motion.slope = 0;
  motion.speed_swing = 0;
  const World world(Geodetic{46.1 * kDegree, 7.2 * kDegree, 2000});
  const Truth truth(world, motion, 3, 1000);
  EXPECT_LT((truth.at(1070).p_wb - truth.at(1000).p_wb).norm(), 0.1);
  EXPECT_NEAR(truth.at(1040).v_wb.norm(), motion.speed, 0.1);
}

TEST(Truth, AttachedTwiceIsAttachedOnce) {
  const Truth r = imu_truth(lively());
  const Quaterniond q1 = from_euler({0.3, 0.1, -0.2}), q2 = from_euler({-0.1, 0.4, 0.2});
  const Vector3d l1(0.1, 0.2, 0.3), l2(-0.2, 0.1, 0);
  const TruthState a = r.attached(q1, l1).attached(q2, l2).at(1035);
  const TruthState b = r.attached(q1 * q2, l1 + q1 * l2).at(1035);
  EXPECT_LT((a.p_wb - b.p_wb).norm(), 1e-12);
  EXPECT_LT((a.f_ib_b - b.f_ib_b).norm(), 1e-9);
  EXPECT_LT((a.w_ib_b - b.w_ib_b).norm(), 1e-12);
}

}  // namespace
}  // namespace piste
