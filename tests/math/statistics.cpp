// Quantiles against printed tables.

#include "piste/math/statistics.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

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

TEST(Statistics, MedianByAxis) {
  const std::vector<Eigen::Vector3d> values{{1, 9, -1}, {5, 2, -3}, {3, 4, -2}};
  EXPECT_EQ(median_by_axis(values), Eigen::Vector3d(3, 4, -2));
}

// The fifteen p-values of Benjamini and Hochberg 1995 (J. Royal Statistical Society B 57, section 4), of which tests
// that keep the probability of any false finding below 5 % let three pass.
TEST(Statistics, HolmStopsWhereItShould) {
  const std::vector<double> p{0.0344, 0.0001, 0.0004, 0.0019, 0.0095, 0.0201, 0.0278, 0.0298,
                              0.0459, 0.3240, 0.4262, 0.5719, 0.6528, 0.7590, 1.0000};
  const std::vector<double> adjusted = holm(p);
  EXPECT_NEAR(adjusted[1], 15 * 0.0001, 1e-12);
  EXPECT_NEAR(adjusted[2], 14 * 0.0004, 1e-12);
  EXPECT_NEAR(adjusted[3], 13 * 0.0019, 1e-12);
  EXPECT_NEAR(adjusted[4], 12 * 0.0095, 1e-12);
  EXPECT_EQ(std::count_if(adjusted.begin(), adjusted.end(), [](double a) { return a < 0.05; }), 3);
  EXPECT_NEAR(adjusted[0], 0.278, 1e-12) << "10 · 0.0278, of a smaller one, is more than 8 · 0.0344";
  EXPECT_EQ(adjusted[14], 1);
}

TEST(Statistics, HolmIsMonotoneAndKeepsWhatIsNoNumber) {
  const double none = std::numeric_limits<double>::quiet_NaN();
  const std::vector<double> adjusted = holm({0.04, none, 0.03, 0.01, 0.005});
  EXPECT_NEAR(adjusted[0], 0.06, 1e-15) << "not below that of a smaller p";
  EXPECT_TRUE(std::isnan(adjusted[1]));
  EXPECT_NEAR(adjusted[2], 0.06, 1e-15);
  EXPECT_NEAR(adjusted[3], 0.03, 1e-15);
  EXPECT_NEAR(adjusted[4], 0.02, 1e-15);
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
