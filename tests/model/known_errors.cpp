// What known errors make of a sample, their removal takes back: each by itself, and all of them together.

#include "piste/model/known_errors.h"

#include <gtest/gtest.h>

#include <functional>

#include "support/random.h"

namespace piste {
namespace {

Vector3d made(const Vector3d& x, const KnownTriadErrors& e) {
  Vector3d out = x + e.gain * x + e.bias;
  for (int k = 0; k < 3; ++k) out(k) += e.quadratic(k) * x(k) * x(k) + e.cubic(k) * x(k) * x(k) * x(k);
  return out;
}

ImuSample measured(const ImuSample& truth, const KnownErrors& e) {
  ImuSample out = truth;
  const double dt = truth.interval;
  const Vector3d f = truth.dvel / dt;
  out.dvel = dt * made(f, e.accel);
  out.dtheta = dt * (made(truth.dtheta / dt, e.gyro) + e.g_sensitivity * f);
  return out;
}

ImuSample sample(test::Random& random) {
  const double dt = 0.005 + 0.01 * random.uniform();
  return {.time = 12, .interval = dt, .dtheta = dt * random.vector(2), .dvel = dt * random.vector(10)};
}

Matrix3d matrix(test::Random& random, double sigma) { return sigma * random.matrix(3, 3); }

TEST(KnownErrors, EachIsTakenBackAsItWasMade) {
  test::Random random(1);
  const std::vector<std::function<void(KnownErrors&)>> members{
      [&](KnownErrors&) {},
      [&](KnownErrors& e) { e.gyro.bias = random.vector(0.1); },
      [&](KnownErrors& e) { e.accel.bias = random.vector(0.3); },
      [&](KnownErrors& e) { e.gyro.gain = matrix(random, 0.03); },
      [&](KnownErrors& e) { e.accel.gain = matrix(random, 0.03); },
      [&](KnownErrors& e) { e.gyro.quadratic = random.vector(3e-3); },
      [&](KnownErrors& e) { e.accel.quadratic = random.vector(5e-4); },
      [&](KnownErrors& e) { e.gyro.cubic = random.vector(1e-3).cwiseAbs(); },
      [&](KnownErrors& e) { e.accel.cubic = random.vector(5e-5).cwiseAbs(); },
      [&](KnownErrors& e) { e.g_sensitivity = matrix(random, 3e-4); },
      [&](KnownErrors& e) {
        e.gyro = {random.vector(0.1), matrix(random, 0.03), random.vector(3e-3), random.vector(1e-3).cwiseAbs()};
        e.accel = {random.vector(0.3), matrix(random, 0.03), random.vector(5e-4), random.vector(5e-5).cwiseAbs()};
        e.g_sensitivity = matrix(random, 3e-4);
      }};
  for (std::size_t m = 0; m < members.size(); ++m) {
    for (int i = 0; i < 200; ++i) {
      KnownErrors errors;
      members[m](errors);
      const ImuSample truth = sample(random), seen = measured(truth, errors), back = corrected(seen, errors);
      EXPECT_EQ((seen.dtheta - truth.dtheta).norm() + (seen.dvel - truth.dvel).norm() > 1e-9, m > 0) << m;
      EXPECT_LT((back.dtheta - truth.dtheta).norm(), 1e-14) << m;
      EXPECT_LT((back.dvel - truth.dvel).norm(), 1e-13) << m;
    }
  }
}

TEST(KnownErrors, AllElseIsKept) {
  const ImuSample in{
      .time = 3, .interval = 0.01, .clipped_gyro = 1, .clipped_accel = 4, .gap = GapNoise{1, 3}, .at_rest = true};
  KnownErrors errors;
  errors.gyro.bias.setConstant(0.1);
  const ImuSample out = corrected(in, errors);
  EXPECT_EQ(out.time, 3);
  EXPECT_EQ(out.interval, 0.01);
  EXPECT_EQ(out.clipped_gyro, 1);
  EXPECT_EQ(out.clipped_accel, 4);
  EXPECT_TRUE(out.gap && out.at_rest);
  EXPECT_NEAR(out.dtheta.x(), -0.001, 1e-15);
  EXPECT_EQ(out.dvel, Vector3d::Zero());
}

}  // namespace
}  // namespace piste
