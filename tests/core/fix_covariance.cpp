// Correlations of a position's errors, and the factor of its covariance.

#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <cmath>
#include <limits>

#include "piste/core/log.h"
#include "support/random.h"

namespace piste {
namespace {

Matrix3d some_covariance(test::Random& random) {
  Matrix3d root;
  for (int i = 0; i < 3; ++i) root.col(i) = random.vector(0.5);
  return root * root.transpose() + 0.02 * Matrix3d::Identity();
}

TEST(FixCovariance, FactorGivesItBack) {
  test::Random random(1);
  for (int i = 0; i < 50; ++i) {
    const Matrix3d covariance = some_covariance(random);
    GnssFix fix;
    fix.sigma_position = covariance.diagonal().cwiseSqrt();
    fix.correlation = correlations(covariance);
    const Matrix3d L = fix.position_factor();
    EXPECT_TRUE((L * L.transpose()).isApprox(covariance, 1e-12));
    EXPECT_TRUE(L.isLowerTriangular());
  }
}

TEST(FixCovariance, WithoutCorrelationsIsThatOfTheSigmas) {
  GnssFix fix;
  fix.sigma_position = {1, 2, 3};
  EXPECT_EQ(fix.position_factor(), Matrix3d(fix.sigma_position.asDiagonal()));
}

// As rounded digits may have it: north and east of one size, and as large a covariance.
TEST(FixCovariance, WhatIsNoCovarianceBecomesOne) {
  Matrix3d rounded = 0.01 * Matrix3d::Identity();
  rounded(0, 1) = rounded(1, 0) = 0.0101;
  rounded(0, 2) = rounded(2, 0) = -0.009;
  const Correlation found = correlations(rounded);
  GnssFix fix;
  fix.sigma_position.setConstant(0.1);
  fix.correlation = found;
  const Matrix3d L = fix.position_factor();
  EXPECT_TRUE(L.allFinite());
  const Eigen::SelfAdjointEigenSolver<Matrix3d> solver(L * L.transpose());
  EXPECT_NEAR(solver.eigenvalues().x(), 0.01 * 0.01, 1e-8);
  EXPECT_NEAR(found.y() / found.x(), -0.9 / 1.01, 1e-12) << "all are made smaller alike";
}

TEST(FixCovariance, WithoutVarianceThereIsNoCorrelation) {
  EXPECT_EQ(correlations(Matrix3d::Zero()), Correlation::Zero());
  EXPECT_EQ(correlations(Matrix3d::Constant(std::numeric_limits<double>::quiet_NaN())), Correlation::Zero());
}

// After a change of what is stated, half of the way of the variance takes 60 s ln 2.
TEST(SlowLevel, FollowsWhatIsStated) {
  SlowLevel level;
  const Vector3d one = Vector3d::Ones();
  EXPECT_EQ(level.next(0, one), one);
  EXPECT_EQ(level.next(1, one), one);
  double variance = 1, time = 1;
  for (int k = 0; k < 10; ++k) {
    time += 6 * std::log(2.0);
    variance = 4 * std::pow(level.next(time, 2 * one).x(), 2);
  }
  EXPECT_NEAR(variance, 2.5, 1e-9);
  for (int k = 0; k < 200; ++k) level.next(time += 5, 2 * one);
  EXPECT_NEAR(level.next(time + 1, 2 * one).x(), 1, 1e-6);
}

// Fixes of another kind, stated 40 times better or worse: theirs is a new error, of their own size, and of that alone.
TEST(SlowLevel, FixesOfAnotherKindHaveAnErrorOfTheirOwn) {
  SlowLevel level;
  const Vector3d one = Vector3d::Ones(), other(1.0 / 40, 1, 40);
  double time = 0;
  for (; time < 100; time += 1) level.next(time, one);
  EXPECT_EQ(level.take_change(), Vector3d::Zero()) << "nothing has changed";
  for (const Vector3d& stated : {other, one, other}) {
    EXPECT_TRUE(level.next(time, stated).isApprox(one, 1e-12));
    const Vector3d change = level.take_change();
    EXPECT_NEAR(change.x(), std::pow(std::log(40), 2), 1e-9);
    EXPECT_EQ(change.y(), 0);
    for (const double end = time + 100; time < end; time += 1)
      EXPECT_TRUE(level.next(time, stated).isApprox(one, 1e-12));
    EXPECT_EQ(level.take_change(), Vector3d::Zero()) << "no trend is left";
  }
}

// Sigmas that scatter by a third from fix to fix change the size by little: less than a tenth of its variance in a
// minute.
TEST(SlowLevel, ScatterIsNoChange) {
  SlowLevel level;
  const double sigmas[] = {0.8, 1.2, 1.0, 0.7, 1.3};
  double change = 0, least = 1, most = 1;
  for (int k = 0; k < 660; ++k) {
    const double sigma = sigmas[k * k % 5];
    const double size = sigma * level.next(k, Vector3d::Constant(sigma)).x();
    const double added = level.take_change().x();
    if (k < 60) continue;
    change += added;
    least = std::min(least, size);
    most = std::max(most, size);
  }
  EXPECT_LT(change / 10, 0.1);
  EXPECT_LT(most / least, 1.2);
}

}  // namespace
}  // namespace piste
