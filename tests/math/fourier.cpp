#include "math/fourier.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "support/random.h"

namespace piste {
namespace {

TEST(FourierTransform, IsTheSumThatDefinesIt) {
  test::Random random(1);
  FourierTransform fourier;
  for (const std::size_t n : {std::size_t{2}, std::size_t{6}, std::size_t{16}, std::size_t{15}}) {
    std::vector<double> x(n);
    for (double& value : x) value = random.gaussian();
    const std::vector<std::complex<double>> X = fourier.forward(x);
    ASSERT_EQ(X.size(), n);
    for (std::size_t k = 0; k < n; ++k) {
      std::complex<double> sum = 0;
      for (std::size_t i = 0; i < n; ++i) {
        sum += x[i] * std::polar(1.0, -2 * std::numbers::pi * static_cast<double>(i * k) / static_cast<double>(n));
      }
      EXPECT_LT(std::abs(X[k] - sum), 1e-13) << k << " of " << n;
    }
  }
}

TEST(FourierTransform, InverseUndoesIt) {
  test::Random random(2);
  FourierTransform fourier;
  std::vector<double> x(1024);
  for (double& value : x) value = random.gaussian();
  const std::vector<double> again = fourier.inverse(fourier.forward(x));
  ASSERT_EQ(again.size(), x.size());
  for (std::size_t i = 0; i < x.size(); ++i) EXPECT_NEAR(again[i], x[i], 1e-14);
}

}  // namespace
}  // namespace piste
