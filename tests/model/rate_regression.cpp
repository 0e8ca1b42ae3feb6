#include "piste/model/rate_regression.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <vector>

#include "piste/core/estimate.h"
#include "support/random.h"

namespace piste {
namespace {

constexpr double kRateInterval = 0.01, kRateNoise = 0.01;  // s; rad/s of one sample

struct Rates {
  std::vector<Vector3d> truth, measured;
  Vector3d beside(std::size_t k) const { return 0.5 * (measured[k - 1] + measured[k + 1]); }
};

Rates rates(double length, const std::function<Vector3d(double)>& truth, std::uint64_t seed) {
  Rates r;
  test::Random random(seed);
  for (double t = 0; t < length; t += kRateInterval) {
    r.truth.push_back(truth(t));
    r.measured.push_back(r.truth.back() + random.vector(kRateNoise));
  }
  return r;
}

ImuSample sample_of(const Vector3d& rate) {
  ImuSample sample;
  sample.interval = kRateInterval;
  sample.dtheta = kRateInterval * rate;
  return sample;
}

RateRegression regression_of(const Rates& r, const Estimate& x = {}) {
  RateRegression g;
  for (std::size_t k = 1; k + 1 < r.truth.size(); ++k) {
    g.add(sample_of(r.measured[k]), r.beside(k), x);
  }
  return g;
}

TEST(RateRegression, LeavesNothingOfNoise) {
  EXPECT_EQ(RateRegression().matrix(), Matrix3d::Identity());
  const Matrix3d G = regression_of(rates(
                                       60, [](double) { return Vector3d::Zero(); }, 1))
                         .matrix();
  // Each element has a standard deviation of sqrt(2 / n), with twice the memory's samples in n.
  const double sigma = std::sqrt(kRateInterval / RateRegression::kMemory);
  EXPECT_LT(G.cwiseAbs().maxCoeff(), 4 * sigma);
  EXPECT_GT(G.cwiseAbs().maxCoeff(), 0.1 * sigma);
}

TEST(RateRegression, KeepsTheAxisAboutWhichABodyTurns) {
  const Vector3d axis = Vector3d(1, 2, -2) / 3;
  const Matrix3d G = regression_of(rates(
                                       60, [&](double) { return Vector3d(0.3 * axis); }, 2))
                         .matrix();
  EXPECT_LT((G - axis * axis.transpose()).cwiseAbs().maxCoeff(), 0.15);
  EXPECT_NEAR(axis.dot(G * axis), 1, 0.01);
}

// The product of a Jacobian G ω̃ with what the rate does, ω, has the mean of its own square: the Jacobian is as large as
// it is true. That of ω̃ itself is larger by `noisy`.
TEST(RateRegression, IsAsLargeAsItIsTrue) {
  const auto sway = [](double t) {
    return Vector3d(0.008 * std::sin(3 * t), 0.005 * std::cos(5 * t), 0.02 * std::sin(t));
  };
  const Rates r = rates(2000, sway, 3);
  RateRegression g;
  Vector3d told = Vector3d::Zero(), square = Vector3d::Zero(), noisy = Vector3d::Zero();
  for (std::size_t k = 1; k + 1 < r.truth.size(); ++k) {
    const Vector3d w = g.matrix() * r.beside(k);
    if (k > 1000) {
      told += w.cwiseProduct(r.truth[k]);
      square += w.cwiseAbs2();
      noisy += r.beside(k).cwiseAbs2() - r.beside(k).cwiseProduct(r.truth[k]);
    }
    g.add(sample_of(r.measured[k]), r.beside(k), {});
  }
  for (int i = 0; i < 3; ++i) {
    EXPECT_LT(std::abs(square(i) - told(i)), 0.02 * noisy(i)) << i;
    EXPECT_GT(told(i), 0.02 * noisy(i)) << i;
  }
}

TEST(RateRegression, TakesTheEstimatedErrorsOff) {
  Estimate x;
  x.gyro_bias = Vector3d(0.2, -0.1, 0.05);
  Rates r = rates(
      60, [](double) { return Vector3d::Zero(); }, 4);
  for (Vector3d& w : r.measured) w += x.gyro_bias;
  EXPECT_LT(regression_of(r, x).matrix().cwiseAbs().maxCoeff(), 0.2);
  EXPECT_GT(regression_of(r).matrix().trace(), 0.9);  // a bias that is not known is a turn
}

// Of what does not move and has no noise there is nothing to be told; a sample without neighbours tells nothing.
TEST(RateRegression, IsFiniteWhereNothingMoves) {
  Rates r = rates(
      1, [](double) { return Vector3d::Zero(); }, 5);
  for (Vector3d& w : r.measured) w = Vector3d(0, 0, 1e-3);
  const Matrix3d G = regression_of(r).matrix();
  EXPECT_TRUE(G.allFinite());
  EXPECT_NEAR(G(2, 2), 1, 1e-6);
  EXPECT_EQ(G.topLeftCorner(2, 2), Eigen::Matrix2d::Zero());
  RateRegression g;
  g.add(sample_of(Vector3d::Zero()), Vector3d::Zero(), {});
  EXPECT_EQ(g.matrix(), Matrix3d::Identity());
}

}  // namespace
}  // namespace piste
