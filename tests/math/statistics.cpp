// Quantiles against printed tables.

#include "piste/math/statistics.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace piste {
namespace {

TEST(Statistics, StudentsT) {
  EXPECT_NEAR(student_quantile(0.975, 1), 12.706205, 1e-6);
  EXPECT_NEAR(student_quantile(0.975, 10), 2.228139, 1e-6);
  EXPECT_NEAR(student_two_sided(2.228139, 10), 0.05, 1e-7);
  EXPECT_DOUBLE_EQ(student_two_sided(0, 3.5), 1);
  EXPECT_NEAR(student_quantile(0.975, 1e8), normal_quantile(0.975), 1e-6);
}

TEST(Statistics, Median) {
  EXPECT_EQ(median({3}), 3);
  EXPECT_EQ(median({5, 1, 9}), 5);
  EXPECT_EQ(median({4, 1, 3, 2}), 3);
}

TEST(Statistics, HolmStepsDown) {
  const double none = std::numeric_limits<double>::quiet_NaN();
  const auto adjusted = holm({0.01, 0.04, none, 0.03, 0.005});
  EXPECT_DOUBLE_EQ(adjusted[4], 4 * 0.005);
  EXPECT_DOUBLE_EQ(adjusted[0], 3 * 0.01);
  EXPECT_DOUBLE_EQ(adjusted[3], 2 * 0.03);
  EXPECT_DOUBLE_EQ(adjusted[1], 2 * 0.03) << "never below one that was rejected before it";
  EXPECT_TRUE(std::isnan(adjusted[2]));
  EXPECT_EQ(holm({0.7, 0.6}), (std::vector{1.0, 1.0}));
  EXPECT_TRUE(holm({}).empty());
}

TEST(Statistics, ChiSquaredBand) {
  EXPECT_NEAR(chi_squared_quantile(0.95, 3), 7.814728, 1e-6);
  const Band band = chi_squared_band(0.95, 3, 50);
  EXPECT_NEAR(3 * band.low, 2.36, 0.005);
  EXPECT_NEAR(3 * band.high, 3.72, 0.005);
}

}  // namespace
}  // namespace piste
