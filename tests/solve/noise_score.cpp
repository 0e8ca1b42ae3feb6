// What noise tells of the scales: the formula, what a bias hides, and when nothing is said.

#include "piste/solve/noise_score.h"

#include <gtest/gtest.h>

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

Covariance known(const StateLayout& layout, double attitude, double velocity) {
  Covariance P = Covariance::Identity(layout.size(), layout.size());
  P.diagonal().segment<3>(layout.offset(Block::kAttitude)).setConstant(attitude);
  P.diagonal().segment<3>(layout.offset(Block::kVelocity)).setConstant(velocity);
  return P;
}

TEST(NoiseScore, IsTheNoiseOverWhatWasKnownBeforeAndAfter) {
  const FilterOptions options = options_with(kAll);
  const StateLayout layout(options.estimate);
  NoiseScore noise(options, layout);
  noise.add(0.07);
  noise.add(0.03);
  noise.before_fix({}, known(layout, 4e-4, 9e-4));
  noise.before_fix({}, known(layout, 3e-4, 5e-4));  // a second channel of the same fix
  const auto score = noise.after_fixes({}, known(layout, 1e-4, 1e-4));
  ASSERT_TRUE(score);
  EXPECT_NEAR((*score)(0), 4e-6 * 0.1 / 5e-4, 1e-12);
  EXPECT_NEAR((*score)(2), (*score)(0), 1e-12);
  EXPECT_NEAR((*score)(4), 9e-6 * 0.1 / 10e-4, 1e-12);
  EXPECT_FALSE(noise.after_fixes({}, known(layout, 1e-4, 1e-4)));
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
  const auto score_of = [&](const Covariance& covariance) {
    NoiseScore noise(options, layout);
    noise.add(0.1);
    noise.before_fix({}, covariance);
    return *noise.after_fixes({}, covariance);
  };
  EXPECT_LT((score_of(hidden) - score_of(P)).head<3>().cwiseAbs().maxCoeff(), 1e-9);
}

TEST(NoiseScore, SaysNothingAtRestNorOfWhatIsMendedOrKnown) {
  const StateLayout layout(kAll);
  NoiseScore at_rest(options_with(kAll), layout);
  at_rest.before_fix({}, known(layout, 1e-4, 1e-4));
  EXPECT_FALSE(at_rest.after_fixes({}, known(layout, 1e-4, 1e-4)));

  FilterOptions mended = options_with(kAll);
  mended.attitude.resize(1);
  NoiseScore with_reference(mended, layout);
  with_reference.add(0.1);
  with_reference.before_fix({}, known(layout, 1e-4, 1e-4));
  const auto score = with_reference.after_fixes({}, known(layout, 1e-4, 1e-4));
  ASSERT_TRUE(score);
  EXPECT_EQ(score->head<3>(), Vector3d::Zero());
  EXPECT_GT(score->tail<3>().minCoeff(), 0);

  const StateLayout bias(std::vector<Block>{Block::kGyroBias});
  NoiseScore without_scales(options_with({Block::kGyroBias}), bias);
  without_scales.add(0.1);
  without_scales.before_fix({}, known(bias, 1e-4, 1e-4));
  EXPECT_FALSE(without_scales.after_fixes({}, known(bias, 1e-4, 1e-4)));
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
