// Preintegration against the strapdown mechanization, and its derivatives against differences.

#include "model/preintegration.h"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <cmath>
#include <vector>

#include "piste/math/statistics.h"
#include "support/random.h"

namespace piste {
namespace {

constexpr double kStep = 0.01;

struct Case {
  World world{Geodetic{0.8, 0.1, 2000}};
  Estimate x;
  std::vector<ImuStep> steps;
};

Case some_case(int count) {
  Case c;
  c.x.q_wb = from_euler(Vector3d(0.3, -0.5, 2));
  c.x.v_wb = {12, -7, 3};
  c.x.p_wb = {900, -400, 100};
  c.x.gyro_bias = {0.01, -0.004, 0.006};
  c.x.accel_bias = {0.05, -0.02, 0.1};
  c.x.gyro_drift = {0.001, 0.002, -0.001};
  c.x.accel_drift = {0.02, 0.01, -0.03};
  c.x.gyro_scale = {0.01, -0.02, 0.005};
  c.x.accel_scale = {-0.01, 0.004, 0.02};
  for (int k = 0; k < count; ++k) {
    const double t = k * kStep;
    const Vector3d rate(std::sin(3 * t), 0.8 * std::cos(2 * t), 1.2), force(3 * std::cos(t), 2, -9.5 + std::sin(5 * t));
    c.steps.push_back({kStep, kStep * rate, kStep * force, Vector3d::Zero(), Vector3d::Zero()});
  }
  return c;
}

const StepNoise kNoise{Vector3d::Constant(1e-6), Vector3d::Constant(4e-6)};
const DriftStep kDrift{0.999, Vector3d::Constant(1e-9)};

ImuSum summed(const Case& c, const Estimate& x) {
  Preintegration sum(x);
  for (const ImuStep& s : c.steps) {
    const ImuStep corrected = correct(s, c.x);
    sum.add(s, kNoise, {.rate = corrected.mean_rate(), .force = corrected.mean_force()}, kDrift, kDrift);
  }
  return sum.sum();
}

using Residual = Eigen::Matrix<double, 9, 1>;

Residual some_residual() { return (Residual() << 0.3, -0.2, 0.1, 0.05, 0.2, -0.1, 0.02, -0.4, 0.3).finished(); }

struct Ends {
  Estimate mechanized, carried;
};

Ends ends(const Case& c, const Gravity& gravity) {
  Estimate x = c.x;
  for (const ImuStep& s : c.steps) {
    mechanize(x, correct(s, x), c.world.earth_rate(), gravity);
    x.gyro_drift *= kDrift.decay;
    x.accel_drift *= kDrift.decay;
  }
  return {x, carry(summed(c, c.x), Residual::Zero(), c.x, c.world.earth_rate(), gravity)};
}

TEST(Preintegration, GoesWhereTheMechanizationGoes) {
  const Case c = some_case(100);
  Gravity even = c.world.gravity(c.x.p_wb);
  even.gradient.setZero();
  const Ends e = ends(c, even);
  EXPECT_LT((e.carried.p_wb - e.mechanized.p_wb).norm(), 1e-7);
  EXPECT_LT((e.carried.v_wb - e.mechanized.v_wb).norm(), 1e-7);
  EXPECT_LT(so3_log(e.carried.q_wb * e.mechanized.q_wb.conjugate()).norm(), 1e-12);
}

// Gravity is taken where the velocity at the start leads. The body accelerates away from there: by up to a T²/6 on
// average, over which gravity changes by its gradient.
TEST(Preintegration, LeavesOutOfGravityOnlyWhatAccelerationChanges) {
  const Case c = some_case(100);
  const Gravity gravity = c.world.gravity(c.x.p_wb);
  const Ends e = ends(c, gravity);
  constexpr double kTime = 1, kMost = 15;  // s; m/s²
  const double change = gravity.gradient.norm() * kMost * kTime * kTime / 6;
  EXPECT_LT((e.carried.v_wb - e.mechanized.v_wb).norm(), change * kTime);
  EXPECT_LT((e.carried.p_wb - e.mechanized.p_wb).norm(), change * kTime * kTime / 2);
}

TEST(Preintegration, CompareUndoesCarry) {
  const Case c = some_case(50);
  const Gravity gravity = c.world.gravity(c.x.p_wb);
  const ImuSum sum = summed(c, c.x);
  const Residual residual = some_residual();
  const Estimate end = carry(sum, residual, c.x, c.world.earth_rate(), gravity);
  const SumResidual r = compare(sum, ImuErrorVector::Zero(), c.x, end, c.world.earth_rate(), gravity);
  EXPECT_LT((r.value - residual).cwiseAbs().maxCoeff(), 1e-10);
}

TEST(Preintegration, DerivativesAreThoseOfDifferences) {
  const Case c = some_case(50);
  const Gravity gravity = c.world.gravity(c.x.p_wb);
  const ImuSum sum = summed(c, c.x);
  const Residual residual = some_residual();
  const Estimate end = carry(sum, residual, c.x, c.world.earth_rate(), gravity);
  ImuErrorVector change;
  for (int k = 0; k < kImuErrorSize; ++k) change(k) = 1e-3 * (k % 5 - 2);
  const auto at = [&](const Estimate& a, const Estimate& b, const ImuErrorVector& d) {
    return compare(sum, d, a, b, c.world.earth_rate(), gravity).value;
  };
  const SumResidual r = compare(sum, change, c.x, end, c.world.earth_rate(), gravity);
  constexpr double kH = 1e-5;
  for (int k = 0; k < 9; ++k) {
    const FullError e = kH * FullError::Unit(k);
    const auto start = ((at(boxplus(c.x, e), end, change) - at(boxplus(c.x, -e), end, change)) / (2 * kH)).eval();
    const auto finish = ((at(c.x, boxplus(end, e), change) - at(c.x, boxplus(end, -e), change)) / (2 * kH)).eval();
    EXPECT_LT((start - r.by_start.col(k)).cwiseAbs().maxCoeff(), 2e-7) << k;
    EXPECT_LT((finish - r.by_end.col(k)).cwiseAbs().maxCoeff(), 2e-7) << k;
  }

  const SumTie t = tie_ends(sum, change, c.x, end, c.world.earth_rate(), gravity);
  const Matrix9d to_end = r.by_end.inverse();
  EXPECT_TRUE(t.value == r.value);
  const auto same = [](const Eigen::MatrixXd& a, const Eigen::MatrixXd& b) {
    EXPECT_LT((a - b).cwiseAbs().maxCoeff(), 1e-12 * (1 + b.cwiseAbs().maxCoeff()));
  };
  same(t.by_start, -to_end * r.by_start);
  same(t.by_imu, -to_end * r.by_imu);
  same(t.shift, -to_end * r.value);
  for (int k = 0; k < 9; ++k) {
    Eigen::Matrix<double, 9, 1> column = Matrix9d::Identity().col(k);
    t.turn_to_end(column.data());
    same(column, to_end.col(k));
  }
  for (int k = 0; k < kImuErrorSize; ++k) {
    const ImuErrorVector d = kH * ImuErrorVector::Unit(k);
    const auto by = ((at(c.x, end, change + d) - at(c.x, end, change - d)) / (2 * kH)).eval();
    EXPECT_LT((by - r.by_imu.col(k)).cwiseAbs().maxCoeff(), 2e-7) << k;
  }
}

// The sum made anew with other errors of the IMU, against its derivative.
TEST(Preintegration, SumFollowsTheErrorsOfTheImu) {
  const Case c = some_case(50);
  const ImuSum sum = summed(c, c.x);
  constexpr double kH = 1e-5;
  int k = 0;
  for (const ImuErrorBlock& b : kImuErrorBlocks) {
    for (int i = 0; i < b.size(); ++i, ++k) {
      Estimate more = c.x, less = c.x;
      additive(more, b.block)(i) += kH;
      additive(less, b.block)(i) -= kH;
      const ImuSum above = summed(c, more), below = summed(c, less);
      Eigen::Matrix<double, 9, 1> difference;
      difference << (above.position - below.position), (above.velocity - below.velocity),
          so3_log(sum.turn.conjugate() * above.turn) - so3_log(sum.turn.conjugate() * below.turn);
      difference /= 2 * kH;
      EXPECT_LT((difference - sum.by_imu.col(k)).cwiseAbs().maxCoeff(), 2e-3 * sum.by_imu.col(k).cwiseAbs().maxCoeff())
          << k << ": " << difference.transpose() << "\n   " << sum.by_imu.col(k).transpose();
    }
  }
}

// Mean square, over its size, of the whitened residual of an interval T and of the drifts' change in it, where the
// drifts are a Gauss-Markov process of correlation time τ and the sum is told `gyro` and `accel` of a step. Noise and
// drift are simulated, the residual is taken at the true ends.
double mean_square(double T_over_tau, const DriftStep& told, double decay, int draws) {
  constexpr double kDrift0 = 3e-3, kForce = 10, kWhite = 2e-4;  // rad/s; m/s² per rad/s; rad/s of a step
  constexpr int kCount = 100;
  test::Random random(3);
  const Case clean = some_case(kCount);
  const double step_decay = std::exp(-T_over_tau / kCount), driven = kDrift0 * std::sqrt(1 - step_decay * step_decay);
  const StepNoise noise{Vector3d::Constant(kWhite * kWhite * kStep),
                        Vector3d::Constant(kForce * kForce * kWhite * kWhite * kStep)};
  const DriftStep accel{told.decay, kForce * kForce * told.variance};
  double sum = 0;
  for (int k = 0; k < draws; ++k) {
    Estimate x = clean.x;
    x.gyro_bias = x.accel_bias = x.gyro_scale = x.accel_scale = Vector3d::Zero();
    x.gyro_drift = random.vector(kDrift0);
    x.accel_drift = random.vector(kForce * kDrift0);
    Estimate end = x;
    const Gravity gravity = clean.world.gravity(x.p_wb);
    Preintegration preintegration(x);
    for (const ImuStep& s : clean.steps) {
      mechanize(end, s, clean.world.earth_rate(), gravity);
      ImuStep measured = s;
      const Vector3d gyro = step_decay * end.gyro_drift + random.vector(driven),
                     force = step_decay * end.accel_drift + random.vector(kForce * driven);
      measured.dtheta += 0.5 * kStep * (end.gyro_drift + gyro) + random.vector(kWhite * kStep);
      measured.dvel += 0.5 * kStep * (end.accel_drift + force) + random.vector(kForce * kWhite * kStep);
      end.gyro_drift = gyro;
      end.accel_drift = force;
      preintegration.add(measured, noise, {.rate = s.mean_rate(), .force = s.mean_force()}, told, accel);
    }
    const SumResidual r =
        compare(preintegration.sum(), ImuErrorVector::Zero(), x, end, clean.world.earth_rate(), gravity);
    Eigen::Matrix<double, 15, 1> residual;
    residual << r.value, end.gyro_drift - decay * x.gyro_drift, end.accel_drift - decay * x.accel_drift;
    sum += residual.dot(preintegration.sum().noise.llt().solve(residual)) / 15;
  }
  return sum / draws;
}

// Intervals from a hundredth of the correlation time to ten of them.
TEST(Preintegration, HoldsGaussMarkovDriftsOverAnyInterval) {
  constexpr int kDraws = 400;
  constexpr double kDrift0 = 3e-3;
  const Band band = chi_squared_band(0.999, 15, kDraws);
  for (const double ratio : {0.01, 0.1, 1.0, 10.0}) {
    const double step = std::exp(-ratio / 100);
    const DriftStep gauss_markov{step, Vector3d::Constant(kDrift0 * kDrift0 * (1 - step * step))};
    const double found = mean_square(ratio, gauss_markov, std::exp(-ratio), kDraws);
    EXPECT_GT(found, band.low) << ratio;
    EXPECT_LT(found, band.high) << ratio;
    // A random walk of the same density is the same process in the beginning alone.
    const DriftStep random_walk{1, Vector3d::Constant(2 * kDrift0 * kDrift0 * ratio / 100)};
    const double walk = mean_square(ratio, random_walk, 1, kDraws);
    if (ratio >= 1) {
      EXPECT_LT(walk, band.low) << ratio;
    }
  }
}

}  // namespace
}  // namespace piste
