// What noise tells of the scales: the formula, what a bias hides, and when nothing is said.

#include "piste/solve/noise_score.h"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <array>
#include <cmath>
#include <random>
#include <vector>

#include "piste/math/so3.h"

namespace piste {
namespace {

FilterOptions options_with(std::vector<Block> estimate) {
  FilterOptions options;
  options.sensor.gyro.noise = 2e-3;
  options.sensor.accel.noise = 3e-3;
  options.estimate = std::move(estimate);
  return options;
}

const std::vector<Block> kAll{Block::kGyroBias, Block::kGyroScale, Block::kAccelScale};

const Vector3d kNoGravity = Vector3d::Zero();

Covariance known(const StateLayout& layout, double attitude, double velocity) {
  Covariance P = Covariance::Identity(layout.size(), layout.size());
  P.diagonal().segment<3>(layout.offset(Block::kAttitude)).setConstant(attitude);
  P.diagonal().segment<3>(layout.offset(Block::kVelocity)).setConstant(velocity);
  return P;
}

// What fixes of one kind, half a second apart, have told when it no longer changes.
ScaleScore score_of(const FilterOptions& options, const Covariance& before, const Covariance& after,
                    const Estimate& x = {}) {
  NoiseScore noise(options, StateLayout(options.estimate));
  ScaleScore last = ScaleScore::Zero();
  for (int i = 0; i < 200; ++i) {
    noise.add(0.3);
    noise.add(0.2);
    noise.before_fix(x, before);
    noise.before_fix(x, before);  // a second channel of the same fix
    last = noise.after_fixes(x, after, kNoGravity).value();
    EXPECT_FALSE(noise.after_fixes(x, after, kNoGravity));
  }
  return last;
}

TEST(NoiseScore, IsTheNoiseOverWhatWasKnownBeforeAndAfter) {
  const FilterOptions options = options_with(kAll);
  const StateLayout layout(options.estimate);
  const ScaleScore score = score_of(options, known(layout, 4e-4, 9e-4), known(layout, 1e-4, 1e-4));
  EXPECT_NEAR(score(0), 4e-6 * 0.5 / 5e-4, 1e-12);
  EXPECT_NEAR(score(2), score(0), 1e-12);
  EXPECT_NEAR(score(4), 9e-6 * 0.5 / 10e-4, 1e-6);  // it moves the position, too
}

TEST(NoiseScore, WaitsForHalfASecond) {
  const FilterOptions options = options_with(kAll);
  const StateLayout layout(options.estimate);
  NoiseScore noise(options, layout);
  for (int i = 1; i <= 12; ++i) {
    noise.add(0.1);
    noise.before_fix({}, known(layout, 4e-4, 9e-4));
    EXPECT_EQ(noise.after_fixes({}, known(layout, 1e-4, 1e-4), kNoGravity).has_value(), i % 5 == 0);
  }
}

// The rate that turns the attitude is the measured one over 1 + s, and its derivative by s has this squared.
TEST(NoiseScore, IsThatOfTheEstimatedScale) {
  const FilterOptions options = options_with(kAll);
  const StateLayout layout(options.estimate);
  const auto score_with = [&](const Vector3d& scale) {
    Estimate x;
    x.gyro_scale = x.accel_scale = scale;
    return score_of(options, known(layout, 4e-4, 9e-4), known(layout, 1e-4, 1e-4), x);
  };
  const ScaleScore ratio = score_with({0.1, 0, -0.1}).cwiseQuotient(score_with({0, 0, 0}));
  EXPECT_NEAR(ratio(0), 1 / 1.331, 1e-12);
  EXPECT_NEAR(ratio(1), 1, 1e-12);
  EXPECT_NEAR(ratio(5), 1 / 0.729, 1e-12);
}

// The exact mean is the trace of Hᵀ S⁻¹ H N over all fixes, N being the covariance of what this noise alone has made of
// the errors.
TEST(NoiseScore, IsExactHoweverTheNoiseIsSeen) {
  using Matrix9d = Eigen::Matrix<double, 9, 9>;
  constexpr double kStep = 0.01, kOfPosition = 0.01, kOfVelocity = 0.03;
  const Vector3d gravity(0, 0, 9.8);
  const FilterOptions options = options_with({Block::kGyroScale, Block::kAccelScale});
  const StateLayout layout(options.estimate);
  Matrix9d Phi = Matrix9d::Identity();
  Phi.block<3, 3>(0, 3).diagonal().setConstant(kStep);
  Phi.block<3, 3>(3, 6) = kStep * skew(gravity);
  for (const int every : {10, 100}) {
    for (const bool positions : {false, true}) {
      for (const bool velocities : {false, true}) {
        if (!positions && !velocities) continue;
        Eigen::MatrixXd H(0, 9);
        std::vector<double> variances;
        const auto measure = [&](int state, double sigma) {
          H.conservativeResize(H.rows() + 3, 9);
          H.bottomRows(3).setZero();
          H.bottomRows(3).middleCols(state, 3).setIdentity();
          variances.insert(variances.end(), 3, sigma * sigma);
        };
        if (positions) measure(0, kOfPosition);
        if (velocities) measure(3, kOfVelocity);
        const Eigen::MatrixXd noise_of_fix = Eigen::Map<Eigen::VectorXd>(variances.data(), H.rows()).asDiagonal();
        Covariance P = Covariance::Identity(layout.size(), layout.size());
        P.topLeftCorner<9, 9>() *= 1e-4;
        std::array<Matrix9d, 2> made;  // by the noise of one axis: gyroscope, accelerometer
        made.fill(Matrix9d::Zero());
        std::array<double, 2> exact{}, told{};
        NoiseScore score(options, layout);
        for (int i = 1; i <= 30000; ++i) {
          const std::array<double, 2> density{std::pow(options.sensor.gyro.noise, 2) * kStep,
                                              std::pow(options.sensor.accel.noise, 2) * kStep};
          Matrix9d nav = Phi * P.topLeftCorner<9, 9>() * Phi.transpose();
          for (int k = 0; k < 2; ++k) {
            nav.diagonal().segment<3>(k == 0 ? 6 : 3).array() += density[static_cast<std::size_t>(k)];
            Matrix9d& N = made[static_cast<std::size_t>(k)];
            N = (Phi * N * Phi.transpose()).eval();
            N(k == 0 ? 6 : 3, k == 0 ? 6 : 3) += density[static_cast<std::size_t>(k)];
          }
          P.topLeftCorner<9, 9>() = nav;
          score.add(kStep);
          if (i % every != 0) continue;
          score.before_fix({}, P);
          const Eigen::MatrixXd S_inverse = (H * nav * H.transpose() + noise_of_fix).inverse();
          const Matrix9d information = H.transpose() * S_inverse * H, keep = Matrix9d::Identity() - nav * information;
          P.topLeftCorner<9, 9>() = keep * nav;
          const bool settled = i > 10000;
          for (std::size_t k = 0; k < 2; ++k) {
            if (settled) exact[k] += (information * made[k]).trace();
            made[k] = (keep * made[k] * keep.transpose()).eval();
          }
          const auto now = score.after_fixes({}, P, gravity);
          if (now && settled) told = {told[0] + (*now)(0), told[1] + (*now)(3)};
        }
        EXPECT_NEAR(told[0] / exact[0], 1, 0.02) << every << positions << velocities;
        EXPECT_NEAR(told[1] / exact[1], 1, 0.02) << every << positions << velocities;
      }
    }
  }
}

TEST(NoiseScore, WhatABiasHidesIsNotTheNoise) {
  const FilterOptions options = options_with(kAll);
  const StateLayout layout(options.estimate);
  Covariance P = known(layout, 1e-4, 1), hidden = P;
  // The attitude's error is that of the bias, and 1e-4 beside it.
  const int a = layout.offset(Block::kAttitude), b = layout.offset(Block::kGyroBias);
  for (int k = 0; k < 3; ++k) {
    hidden(a + k, a + k) += 0.25;
    hidden(a + k, b + k) = hidden(b + k, a + k) = 0.5;
  }
  const Covariance after = known(layout, 1e-5, 1);
  EXPECT_LT((score_of(options, hidden, after) - score_of(options, P, after)).head<3>().cwiseAbs().maxCoeff(), 1e-9);
}

TEST(NoiseScore, SaysNothingAtRestNorOfWhatIsMendedOrKnown) {
  const StateLayout layout(kAll);
  NoiseScore at_rest(options_with(kAll), layout);
  at_rest.before_fix({}, known(layout, 1e-4, 1e-4));
  EXPECT_FALSE(at_rest.after_fixes({}, known(layout, 1e-4, 1e-4), kNoGravity));

  FilterOptions mended = options_with(kAll);
  mended.attitude.resize(1);
  NoiseScore with_reference(mended, layout);
  with_reference.add(0.5);
  with_reference.before_fix({}, known(layout, 4e-4, 4e-4));
  const auto score = with_reference.after_fixes({}, known(layout, 1e-4, 1e-4), kNoGravity);
  ASSERT_TRUE(score);
  EXPECT_EQ(score->head<3>(), Vector3d::Zero());
  EXPECT_GT(score->tail<3>().minCoeff(), 0);

  const StateLayout bias(std::vector<Block>{Block::kGyroBias});
  NoiseScore without_scales(options_with({Block::kGyroBias}), bias);
  without_scales.add(0.5);
  without_scales.before_fix({}, known(bias, 1e-4, 1e-4));
  EXPECT_FALSE(without_scales.after_fixes({}, known(bias, 1e-4, 1e-4), kNoGravity));
}

TEST(NoiseScore, ThePullIsTheCovarianceTimesTheScore) {
  const StateLayout layout(std::vector<Block>{Block::kAccelScale});
  Covariance P = Covariance::Identity(layout.size(), layout.size());
  const int s = layout.offset(Block::kAccelScale);
  P(0, s + 1) = P(s + 1, 0) = 0.5;
  ScaleScore score = ScaleScore::Zero();
  score << 7, 7, 7, 0, 2, 0;  // the gyroscopes' scale is not estimated
  const ErrorVector pull = pull_of(score, layout, P);
  EXPECT_EQ(pull(0), 1);
  EXPECT_EQ(pull(s + 1), 2);
  EXPECT_EQ(pull.cwiseAbs().sum(), 3);
  ErrorVector lambda = ErrorVector::Zero(layout.size());
  add_score(lambda, layout, score);
  EXPECT_EQ(lambda(s + 1), 2);
  EXPECT_EQ(lambda.cwiseAbs().sum(), 2);
}

}  // namespace
}  // namespace piste
