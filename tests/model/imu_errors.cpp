#include "piste/model/imu_errors.h"

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

}  // namespace
}  // namespace piste
