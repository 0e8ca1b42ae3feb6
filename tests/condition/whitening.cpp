// The autoregression finds the process that made the noise, and its filter takes the colour out.

#include "condition/whitening.h"

#include <gtest/gtest.h>

#include <cmath>

#include "support/random.h"

namespace piste::test {
namespace {

/// x[k] = 0.9 x[k−1] − 0.4 x[k−2] + e, per axis.
std::vector<Vector3d> process(int count, double sigma) {
  Random random(1);
  std::vector<Vector3d> x(static_cast<std::size_t>(count), Vector3d::Zero());
  for (std::size_t k = 2; k < x.size(); ++k) x[k] = 0.9 * x[k - 1] - 0.4 * x[k - 2] + random.vector(sigma);
  return x;
}

std::vector<Left> left_of(const std::vector<Vector3d>& x) {
  std::vector<Left> left;
  for (const Vector3d& v : x) left.push_back({v, 7});
  return left;
}

TEST(Whitening, FindsTheProcess) {
  const std::vector<Vector3d> x = process(20000, 0.1);
  std::vector<Left> left = left_of(x);
  for (std::size_t k = 100; k < 120; ++k) left[k].axes = 0;  // not to be used, and wild
  for (std::size_t k = 100; k < 120; ++k) left[k].value.setConstant(1e3);
  left[500].value.setConstant(50);  // an outlier
  const Whitening w = autoregression(left, robust_sigma(left));
  ASSERT_EQ(w.taps.size(), 1U + kWhiteningOrder);
  EXPECT_EQ(w.taps[0], 1);
  // Standard errors of some 1 / sqrt(60000).
  EXPECT_NEAR(w.taps[1], -0.9, 0.02);
  EXPECT_NEAR(w.taps[2], 0.4, 0.02);
  EXPECT_NEAR(w.taps[3], 0, 0.02);
  EXPECT_NEAR(w.taps[4], 0, 0.02);
  EXPECT_NEAR(w.gain(), 0.5, 0.03);
}

TEST(Whitening, ItsFilterTakesTheColourOut) {
  const std::vector<Vector3d> x = process(20000, 0.1);
  const Whitening w = autoregression(left_of(x), 1);
  const std::vector<Vector3d> e = w.filter(1)(x);
  double square = 0, product = 0;
  for (std::size_t k = 10; k < e.size(); ++k) {
    square += e[k].squaredNorm();
    product += e[k].dot(e[k - 1]);
  }
  EXPECT_LT(std::abs(product / square), 4 / std::sqrt(3.0 * static_cast<double>(e.size())));
  EXPECT_NEAR(robust_sigma(left_of(e)), 0.1, 0.002);
}

TEST(Whitening, StrideAndTooFewSamples) {
  const std::vector<Vector3d> x = process(100, 1);
  const Whitening w{{1, -0.5}};
  const auto y = w.filter(3)(x);
  EXPECT_LT((y[50] - (x[50] - 0.5 * x[47])).norm(), 1e-15);
  EXPECT_EQ(autoregression(left_of(process(20, 1)), 1).taps.size(), 1U);
  EXPECT_EQ(robust_sigma({}), 0);
}

}  // namespace
}  // namespace piste::test
