#include "model/imu_errors.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>

namespace piste {
namespace {

// Variance of the mean over [a + gap, a + gap + b] less that over [0, a], from the covariance function by midpoints.
double by_sums(const std::function<double(double, double)>& covariance, double a, double gap, double b) {
  constexpr int kSteps = 400;
  double sum = 0;
  const auto mean = [&](double s, double length_s, double t, double length_t) {
    double out = 0;
    for (int i = 0; i < kSteps; ++i) {
      for (int j = 0; j < kSteps; ++j) {
        out += covariance(s + length_s * (i + 0.5) / kSteps, t + length_t * (j + 0.5) / kSteps);
      }
    }
    return out / (kSteps * kSteps);
  };
  sum += mean(0, a, 0, a) + mean(a + gap, b, a + gap, b) - 2 * mean(0, a, a + gap, b);
  return sum;
}

TEST(ChangeSigma, IsThatOfTheMeansOfTwoStretches) {
  using Kind = DriftProcess::Kind;
  const DriftProcess markov{.kind = Kind::kGaussMarkov, .sigma = 0.3, .correlation_time = 200};
  const DriftProcess walk{.kind = Kind::kRandomWalk, .density = 0.02};
  const auto of_markov = [](double s, double t) { return 0.09 * std::exp(-std::abs(s - t) / 200); };
  const auto of_walk = [](double s, double t) { return 4e-4 * std::min(s, t); };
  for (const auto& [a, gap, b] : {std::array{180.0, 0.0, 90.0}, {20.0, 400.0, 900.0}, {5.0, 3.0, 5.0}}) {
    const double m = change_sigma(markov, a, gap, b), w = change_sigma(walk, a, gap, b);
    EXPECT_NEAR(m * m / by_sums(of_markov, a, gap, b), 1, 2e-2);
    EXPECT_NEAR(w * w / by_sums(of_walk, a, gap, b), 1, 2e-2);
  }
  EXPECT_EQ(change_sigma({}, 180, 0, 90), 0);
}

// A process begins as it stays: what its start is known to is what a long step makes of any start.
TEST(InitialSigma, IsThatOfTheProcessAtAnyTime) {
  const DriftProcess markov{.kind = DriftProcess::Kind::kGaussMarkov, .sigma = 0.3, .correlation_time = 200};
  EXPECT_EQ(initial_sigma(markov), 0.3);
  for (const double dt : {0.01, 50.0, 1e6}) {
    const DiscreteProcess step = discretise(markov, dt);
    const double variance = initial_sigma(markov) * initial_sigma(markov);
    EXPECT_NEAR(step.transition * step.transition * variance + step.variance, variance, 1e-15) << dt;
  }
  EXPECT_EQ(initial_sigma({.kind = DriftProcess::Kind::kRandomWalk, .density = 0.02}), 0) << "it starts from nothing";
  EXPECT_EQ(initial_sigma({}), 0);
}

// The means of one stretch cut in two, without a gap, over the same process: changes of neighbours that are so short
// that nothing drifts in them are none, and of a Gauss-Markov process far apart they are those of two draws.
TEST(ChangeSigma, OfShortAndOfDistantStretches) {
  const DriftProcess markov{.kind = DriftProcess::Kind::kGaussMarkov, .sigma = 0.3, .correlation_time = 200};
  EXPECT_LT(change_sigma(markov, 1e-3, 0, 1e-3), 1e-3);
  EXPECT_NEAR(change_sigma(markov, 1e-3, 1e6, 1e-3), 0.3 * std::sqrt(2), 1e-6);
  const DriftProcess walk{.kind = DriftProcess::Kind::kRandomWalk, .density = 0.02};
  EXPECT_NEAR(change_sigma(walk, 1e-6, 100, 1e-6), 0.02 * 10, 1e-6);
}

}  // namespace
}  // namespace piste
