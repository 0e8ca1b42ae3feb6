#include "diagnosis/most_likely_factor.h"

#include <gtest/gtest.h>

namespace piste::test {
namespace {

TEST(MostLikelyFactor, IsTheTopOfAParabolaOverItsLogarithm) {
  for (const double top : {40., 7., 2.2, 0.4, 0.02}) {
    int asked = 0;
    const Factor f = most_likely_factor([&](double factor) {
      ++asked;
      const double here = std::log(factor / top), at_one = std::log(1 / top);
      return 200 * (at_one * at_one - here * here);
    });
    EXPECT_NEAR(std::log(f.value / top), 0, 0.1) << top;
    EXPECT_LT(asked, 20) << top;
  }
}

// The likelihood of a sigma falls steeply where it is too small: no parabola.
TEST(MostLikelyFactor, IsThatOfASigma) {
  for (const double top : {40., 4., 0.3}) {
    const auto likelihood = [top](double factor) {
      return -1e4 * (std::log(factor) + 0.5 * std::pow(top / factor, 2));
    };
    const Factor f = most_likely_factor([&](double factor) { return likelihood(factor) - likelihood(1); });
    EXPECT_NEAR(std::log(f.value / top), 0, 0.06) << top;
  }
}

// A noise below all that can be seen is as likely as none at all.
TEST(MostLikelyFactor, OfThoseAsLikelyIsTheNearest) {
  const Factor f = most_likely_factor([](double factor) { return 20 * (1 - factor) / (1 + factor); });
  EXPECT_GT(f.value, 0.01);
  EXPECT_GT(f.gain, 18.9);
  EXPECT_EQ(most_likely_factor([](double factor) { return -std::abs(std::log(factor)); }).value, 1);
}

}  // namespace
}  // namespace piste::test
