// Quantiles against printed tables.

#include "piste/math/statistics.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>
#include <vector>

namespace piste {
namespace {

TEST(Statistics, MeansAndSpreadsOfAFewValues) {
  const std::vector<double> values{2, 4, 4, 4, 5, 5, 7, 9}, one{3}, none;
  EXPECT_DOUBLE_EQ(mean(values), 5);
  EXPECT_DOUBLE_EQ(root_mean_square(values), std::sqrt(29.0));
  EXPECT_EQ(root_mean_square(none), 0);
  EXPECT_DOUBLE_EQ(standard_deviation(values), std::sqrt(32.0 / 7)) << "over one less than their number";
  EXPECT_DOUBLE_EQ(standard_error(values), std::sqrt(32.0 / 7 / 8));
  EXPECT_NEAR(zero_mean_p_value(values), student_two_sided(5 / std::sqrt(32.0 / 7 / 8), 7), 1e-15);
  for (const double of_one : {standard_deviation(one), standard_error(one), zero_mean_p_value(one)}) {
    EXPECT_TRUE(std::isnan(of_one));
  }
  EXPECT_EQ(zero_mean_p_value(std::vector<double>{0, 0}), 1);
  EXPECT_EQ(zero_mean_p_value(std::vector<double>{1, 1}), 0);
}

// Means of many series of an autoregressive process scatter as each series by itself says.
TEST(Statistics, StandardErrorOfASeries) {
  constexpr std::size_t kRuns = 400, kLength = 2000;
  std::mt19937_64 random(1);
  std::normal_distribution<double> normal;
  for (const double rho : {0.0, 0.6, 0.9}) {
    std::vector<double> means, errors;
    for (std::size_t run = 0; run < kRuns; ++run) {
      std::vector<double> series(kLength);
      double x = normal(random) / std::sqrt(1 - rho * rho);
      for (double& value : series) value = x = rho * x + normal(random);
      means.push_back(mean(series));
      errors.push_back(standard_error_of_series(series));
    }
    // The scatter of 400 is known to 3.5 %; a long correlation is cut off, and estimated about the mean of the series.
    EXPECT_NEAR(root_mean_square(errors) / standard_deviation(means), 1, 0.12) << rho;
  }
  EXPECT_EQ(standard_error_of_series(std::vector<double>{2, 2, 2}), 0);
}

TEST(Statistics, StudentsT) {
  EXPECT_NEAR(student_quantile(0.975, 1), 12.706205, 1e-6);
  EXPECT_NEAR(student_quantile(0.975, 10), 2.228139, 1e-6);
  EXPECT_NEAR(student_two_sided(2.228139, 10), 0.05, 1e-7);
  EXPECT_DOUBLE_EQ(student_two_sided(0, 3.5), 1);
  EXPECT_NEAR(student_quantile(0.975, 1e8), normal_quantile(0.975), 1e-6);
}

TEST(Statistics, Median) {
  EXPECT_EQ(median(std::vector<double>{3}), 3);
  EXPECT_EQ(median(std::vector<double>{5, 1, 9}), 5);
  EXPECT_EQ(median(std::vector<double>{4, 1, 3, 2}), 3);
}

TEST(Statistics, QuantileHasItsPartOfTheOthersBelow) {
  const std::vector<double> values{30, 10, 50, 20, 40};
  EXPECT_EQ(quantile(values, 0), 10);
  EXPECT_EQ(quantile(values, 0.25), 20);
  EXPECT_EQ(quantile(values, 0.5), 30);
  EXPECT_EQ(quantile(values, 0.7), 30) << "the lower of two";
  EXPECT_EQ(quantile(values, 1), 50);
  EXPECT_EQ(quantile({7}, 0.3), 7);
}

TEST(Statistics, NormalQuantileIsThatOfTables) {
  EXPECT_NEAR(normal_quantile(0.975), 1.959964, 1e-6);
  EXPECT_NEAR(normal_quantile(0.0005), -3.290527, 1e-6);
  EXPECT_NEAR(std::pow(normal_quantile(0.9995), 2), chi_squared_quantile(0.999, 1), 1e-9);
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

TEST(Statistics, ChiSquaredAbove) {
  EXPECT_NEAR(chi_squared_above(7.814728, 3), 0.05, 1e-8);
  for (const double dof : {1.0, 4.0, 200.0}) {
    EXPECT_NEAR(chi_squared_above(chi_squared_quantile(0.999, dof), dof), 0.001, 1e-12);
  }
  EXPECT_EQ(chi_squared_above(0, 3), 1);
  EXPECT_EQ(chi_squared_above(2, 0), 1);
}

TEST(Statistics, ChiSquaredBand) {
  EXPECT_NEAR(chi_squared_quantile(0.95, 3), 7.814728, 1e-6);
  const Band band = chi_squared_band(0.95, 3, 50);
  EXPECT_NEAR(3 * band.low, 2.36, 0.005);
  EXPECT_NEAR(3 * band.high, 3.72, 0.005);
}

}  // namespace
}  // namespace piste
