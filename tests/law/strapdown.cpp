// Mechanization against motions that are known exactly: order of convergence, rest, gravity, the Schuler period.

#include "piste/model/strapdown.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "support/motion.h"
#include "support/random.h"

namespace piste {
namespace {

using test::Random;
using test::WildMotion;

struct Errors {
  double attitude, velocity, position;
};

Errors errors_of(const Estimate& x, const WildMotion::State& truth) {
  return {so3_log(truth.q_wb * x.q_wb.conjugate()).norm(), (truth.v_wb - x.v_wb).norm(), (truth.p_wb - x.p_wb).norm()};
}

// Largest errors over the epochs given by `times`; `cut` may split a step in two.
template <class Cut>
Errors dead_reckon(const std::vector<double>& times, Cut cut) {
  const WildMotion motion;
  const World& world = motion.world;
  // One sample before and one after, so that every step has its slopes.
  std::vector<ImuSample> samples;
  for (std::size_t i = 1; i < times.size(); ++i) samples.push_back(motion.sample(times[i - 1], times[i]));
  const auto start = motion.at(times[1]);
  Estimate x;
  x.q_wb = start.q_wb;
  x.v_wb = start.v_wb;
  x.p_wb = start.p_wb;
  Errors worst{0, 0, 0};
  for (std::size_t i = 1; i + 1 < samples.size(); ++i) {
    const ImuStep step = make_step(&samples[i - 1], samples[i], &samples[i + 1]);
    for (const ImuStep& part : cut(step)) mechanize(x, part, world.earth_rate(), motion.gravity());
    const Errors e = errors_of(x, motion.at(samples[i].time));
    worst = {std::max(worst.attitude, e.attitude), std::max(worst.velocity, e.velocity),
             std::max(worst.position, e.position)};
  }
  return worst;
}

std::vector<ImuStep> whole(const ImuStep& step) { return {step}; }

std::vector<double> even_times(double dt) {
  std::vector<double> times;
  for (int i = -1; i <= static_cast<int>(std::lround(2 / dt)) + 1; ++i) times.push_back(1 + i * dt);
  return times;
}

// Steps that differ by up to 60 % from one to the next.
std::vector<double> uneven_times(double dt) {
  std::vector<double> times{1};
  for (int i = 0; times.back() < 3; ++i) times.push_back(times.back() + dt * (1 + 0.3 * std::sin(2.0 * i)));
  return times;
}

void expect_order(const Errors& coarse, const Errors& fine, double order) {
  EXPECT_GT(std::log2(coarse.attitude / fine.attitude), order) << coarse.attitude << " " << fine.attitude;
  EXPECT_GT(std::log2(coarse.velocity / fine.velocity), order) << coarse.velocity << " " << fine.velocity;
}

TEST(Strapdown, IsOfFourthOrder) {
  const Errors coarse = dead_reckon(even_times(0.01), whole), fine = dead_reckon(even_times(0.005), whole);
  expect_order(coarse, fine, 3.5);
  // Two seconds at 100 Hz with 6 Hz of vibration.
  EXPECT_LT(coarse.attitude, 2e-5);
  EXPECT_LT(coarse.velocity, 2e-4);
  EXPECT_LT(coarse.position, 2e-4);
}

TEST(Strapdown, IsOfFourthOrderOverUnequalSteps) {
  expect_order(dead_reckon(uneven_times(0.01), whole), dead_reckon(uneven_times(0.005), whole), 3.5);
}

TEST(Strapdown, AStepMayBeSplitAnywhere) {
  const auto randomly = [random = Random(1)](const ImuStep& step) mutable -> std::vector<ImuStep> {
    const auto [a, b] = split(step, (0.05 + 0.9 * random.uniform()) * step.dt);
    return {a, b};
  };
  const Errors whole_steps = dead_reckon(even_times(0.01), whole), halves = dead_reckon(even_times(0.01), randomly);
  EXPECT_LT(halves.attitude, 2 * whole_steps.attitude);
  EXPECT_LT(halves.velocity, 2 * whole_steps.velocity);
  expect_order(halves, dead_reckon(even_times(0.005), randomly), 3.0);
}

TEST(Strapdown, PartsOfASplitStepAddUp) {
  Random random(2);
  const ImuStep step{0.01, random.vector(0.03), random.vector(0.2), random.vector(5), random.vector(50)};
  const auto [a, b] = split(step, 0.003);
  EXPECT_DOUBLE_EQ(a.dt + b.dt, step.dt);
  EXPECT_LT((a.dtheta + b.dtheta - step.dtheta).norm(), 1e-17);
  EXPECT_LT((a.dvel + b.dvel - step.dvel).norm(), 1e-16);
  // The line continues: means lie on it, half a step apart.
  EXPECT_LT((b.mean_rate() - a.mean_rate() - 0.005 * step.rate_slope).norm(), 1e-14);
  EXPECT_LT((b.mean_force() - a.mean_force() - 0.005 * step.force_slope).norm(), 1e-13);
}

TEST(Strapdown, SlopesAreThoseOfAParabolaForAnySteps) {
  // Rate = q t²: the slope in the middle of the step, from the means over three unequal steps.
  const Vector3d q(3, -2, 1);
  const auto sample = [&](double a, double b) {
    ImuSample s;
    s.time = b;
    s.interval = b - a;
    s.dtheta = q * (b * b * b - a * a * a) / 3;
    s.dvel = 10 * s.dtheta;
    return s;
  };
  const ImuSample before = sample(0.1, 0.13), now = sample(0.13, 0.14), after = sample(0.14, 0.19);
  const ImuStep step = make_step(&before, now, &after);
  EXPECT_LT((step.rate_slope - 2 * q * 0.135).norm(), 1e-12);
  EXPECT_LT((step.force_slope - 20 * q * 0.135).norm(), 1e-11);
}

TEST(Strapdown, ANeighbourAcrossAGapTellsNothing) {
  const WildMotion motion;
  const ImuSample before = motion.sample(1, 1.01), now = motion.sample(1.01, 1.02);
  ImuSample after = motion.sample(1.03, 1.04);
  EXPECT_EQ(make_step(&before, now, &after).rate_slope, make_step(&before, now, nullptr).rate_slope);
  after = motion.sample(1.02, 1.03);
  after.gap = GapNoise{};
  EXPECT_EQ(make_step(&before, now, &after).rate_slope, make_step(&before, now, nullptr).rate_slope);
  EXPECT_TRUE(make_step(nullptr, now, nullptr).rate_slope.isZero(0));
}

TEST(Strapdown, CorrectionUndoesTheErrorsOfTheImu) {
  Random random(3);
  const Estimate x = random.estimate();
  const ImuStep truth{0.01, random.vector(0.03), random.vector(0.2), random.vector(5), random.vector(50)};
  ImuStep measured = truth;
  Matrix3d gyro, accel, G;
  const Vector3d &a = x.gyro_scale, &b = x.accel_scale, &n = x.accel_cross_axis;
  const auto& m = x.gyro_cross_axis;
  gyro << 1 + a.x(), m(0), m(1), m(2), 1 + a.y(), m(3), m(4), m(5), 1 + a.z();
  accel << 1 + b.x(), 0, 0, n(0), 1 + b.y(), 0, n(1), n(2), 1 + b.z();
  for (int k = 0; k < 9; ++k) G(k / 3, k % 3) = x.gyro_g_sensitivity(k);
  measured.dtheta = gyro * truth.dtheta + G * truth.dvel + truth.dt * (x.gyro_bias + x.gyro_drift);
  measured.dvel = accel * truth.dvel + truth.dt * (x.accel_bias + x.accel_drift);
  measured.rate_slope = gyro * truth.rate_slope + G * truth.force_slope;
  measured.force_slope = accel * truth.force_slope;
  const ImuStep back = correct(measured, x);
  EXPECT_LT((back.dtheta - truth.dtheta).norm(), 1e-16);
  EXPECT_LT((back.dvel - truth.dvel).norm(), 1e-15);
  EXPECT_LT((back.rate_slope - truth.rate_slope).norm(), 1e-14);
  EXPECT_LT((back.force_slope - truth.force_slope).norm(), 1e-13);
}

// Means of a body that stands on the Earth.
ImuStep standing(const Quaterniond& q_wb, const World& world, double dt) {
  const Matrix3d R_bw = q_wb.toRotationMatrix().transpose();
  return {dt, R_bw * world.earth_rate() * dt, -R_bw * world.gravity(Vector3d::Zero()).value * dt, Vector3d::Zero(),
          Vector3d::Zero()};
}

TEST(Strapdown, ABodyAtRestStaysPutForAnHour) {
  const World world({46.5 * 0.017453292519943295, 0.1, 500});
  const Gravity gravity = world.gravity(Vector3d::Zero());
  Estimate x;
  x.q_wb = from_euler({0.1, -0.7, 2});
  const Quaterniond start = x.q_wb;
  const ImuStep step = standing(x.q_wb, world, 0.01);
  for (int i = 0; i < 360000; ++i) mechanize(x, step, world.earth_rate(), gravity);
  EXPECT_LT(x.p_wb.norm(), 1e-3);
  EXPECT_LT(x.v_wb.norm(), 1e-6);
  EXPECT_LT(so3_log(start.conjugate() * x.q_wb).norm(), 1e-10);
}

TEST(Strapdown, HorizontalErrorsSwingWithTheSchulerPeriod) {
  // On an Earth that does not turn; the body is carried with its height held, as that error alone grows.
  const World world({0.8, 0.1, 0});
  const Vector3d still = Vector3d::Zero();
  Estimate x;
  x.v_wb = Vector3d(0.1, 0, 0);
  const double dt = 1;
  const ImuStep step{dt, Vector3d::Zero(), -dt * world.gravity(still).value, still, still};
  std::vector<double> crossings;
  for (int i = 1; i <= 12000; ++i) {
    const double north = x.p_wb.x();
    mechanize(x, step, still, world.gravity(x.p_wb));
    x.p_wb.z() = x.v_wb.z() = 0;
    if (i > 1 && north * x.p_wb.x() < 0) crossings.push_back(i - x.p_wb.x() / (x.p_wb.x() - north));
  }
  ASSERT_GE(crossings.size(), 2U);
  EXPECT_NEAR((crossings[1] - crossings[0]) * 2 / 60, 84.4, 0.3);
}

}  // namespace
}  // namespace piste
