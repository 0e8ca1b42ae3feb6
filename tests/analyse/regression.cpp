// Certified values and standard errors of NIST, and intervals that hold the truth as often as they say.

#include "piste/analyse/regression.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>

#include "piste/core/error.h"
#include "support/nist_strd.h"
#include "support/random.h"

namespace piste {
namespace {

/// Digits on which `value` and `certified` agree.
double digits(double value, double certified) {
  if (value == certified) return 16;
  return -std::log10(std::abs(value - certified) / (certified == 0 ? 1 : std::abs(certified)));
}

void expect_certified(const test::CertifiedRegression& set, const Regression& found, double value_digits,
                      double error_digits) {
  for (std::size_t i = 0; i < set.value.size(); ++i) {
    const Term term = found.term(static_cast<int>(i));
    EXPECT_GT(digits(term.value, set.value[i]), value_digits) << set.name << " value " << i;
    EXPECT_GT(digits(term.sigma, set.standard_error[i]), error_digits) << set.name << " standard error " << i;
  }
  EXPECT_GT(digits(found.residual, set.residual), error_digits) << set.name << " residual";
}

TEST(Regression, NistValuesToNineDigitsAndStandardErrorsToSeven) {
  for (const auto& set :
       {test::norris(), test::pontius(), test::no_intercept_1(), test::no_intercept_2(), test::longley(),
        test::wampler(1), test::wampler(2), test::wampler(3), test::wampler(4), test::wampler(5)}) {
    expect_certified(set, regress(set.X, set.y), 9, 7);
  }
  // The tenth powers of Filip, rounded to double, are worth seven digits.
  expect_certified(test::filip(), regress(test::filip().X, test::filip().y), 6.5, 6.5);
}

TEST(Regression, ALineIsTheSameAboutTheMean) {
  const auto set = test::norris();
  const Regression line = regress_line(set.X.col(1), set.y), general = regress(set.X, set.y);
  expect_certified(set, line, 9, 7);
  EXPECT_NEAR(line.correlation(0, 1), general.correlation(0, 1), 1e-12);
  EXPECT_TRUE(line.hac_covariance.isApprox(general.hac_covariance, 1e-9));
  EXPECT_TRUE(line.inflation.isApprox(general.inflation, 1e-9));
  EXPECT_NEAR(line.correlation(0, 1), -set.X.col(1).mean() / std::sqrt(set.X.col(1).squaredNorm() / 36), 1e-12)
      << "−mean / rms";
}

TEST(Regression, SaysWhichColumnIsOneTooMany) {
  Eigen::MatrixXd X = Eigen::MatrixXd::Random(20, 3);
  X.col(2) = 2 * X.col(0) - X.col(1);
  EXPECT_THROW(regress(X, X.col(0)), DataError);
  X.col(2).setZero();
  EXPECT_THROW(regress(X, X.col(0)), DataError);
  EXPECT_THROW(regress_line(Eigen::VectorXd::Constant(20, 3), X.col(0)), DataError);
}

TEST(Regression, StudentsTAndWelch) {
  const Term term{2.0, 0, 1.0, 10};
  EXPECT_NEAR(term.p_value(), 0.07338803, 1e-7);
  EXPECT_NEAR(term.p_value(4), 0.07338803, 1e-7);
  EXPECT_NEAR(term.half_width(0.95), 2.228139, 1e-6);
  const Term d = difference({3, 0.3, 3, 9}, {1, 0.4, 4, 16});
  EXPECT_DOUBLE_EQ(d.value, 2);
  EXPECT_DOUBLE_EQ(d.sigma, 0.5);
  EXPECT_DOUBLE_EQ(d.standard_error, 5);
  EXPECT_DOUBLE_EQ(d.dof, 625.0 / (81.0 / 9 + 256.0 / 16));
}

using Noise = std::function<Eigen::VectorXd(test::Random&, Eigen::Index)>;

Noise autoregressive(double phi) {
  return [phi](test::Random& random, Eigen::Index n) {
    Eigen::VectorXd e(n);
    e(0) = random.gaussian(1 / std::sqrt(1 - phi * phi));
    for (Eigen::Index t = 1; t < n; ++t) e(t) = phi * e(t - 1) + random.gaussian();
    return e;
  };
}

/// What a low-pass of a tenth of the rate leaves of white noise.
Eigen::VectorXd low_passed(test::Random& random, Eigen::Index n) {
  constexpr Eigen::Index kReach = 30;
  const Eigen::VectorXd white = random.matrix(n + 2 * kReach, 1);
  Eigen::VectorXd e = Eigen::VectorXd::Zero(n);
  for (Eigen::Index k = -kReach; k <= kReach; ++k) {
    const double x = 0.2 * 3.14159265358979 * static_cast<double>(k);
    const double window = 0.5 + 0.5 * std::cos(3.14159265358979 * static_cast<double>(k) / kReach);
    e += (k == 0 ? 1 : std::sin(x) / x) * window * white.segment(kReach + k, n);
  }
  return e;
}

struct Coverage {
  double intercept = 0, slope = 0, formal = 0;  ///< shares of 95 % intervals that hold the truth
};

Coverage coverage(const Noise& noise, Eigen::Index n, int runs) {
  Coverage out;
  Eigen::VectorXd x(n);
  for (Eigen::Index i = 0; i < n; ++i) {
    const auto t = static_cast<double>(i);
    x(i) = 1 + 3 * std::sin(0.01 * t) + std::sin(0.043 * t);
  }
  for (int run = 0; run < runs; ++run) {
    test::Random random(static_cast<std::uint64_t>(run) + 1);
    const Eigen::VectorXd y = 0.5 + 2 * x.array() + noise(random, n).array();
    const Regression line = regress_line(x, y);
    const Term b = line.term(0), k = line.term(1);
    out.intercept += std::abs(b.value - 0.5) < b.half_width(0.95);
    out.slope += std::abs(k.value - 2) < k.half_width(0.95);
    out.formal += std::abs(b.value - 0.5) < 1.96 * b.sigma;
  }
  return {out.intercept / runs, out.slope / runs, out.formal / runs};
}

TEST(Regression, IntervalsHoldTheTruthWhateverTheNoise) {
  struct Case {
    const char* name;
    Noise noise;
    Eigen::Index samples;
    double formal_below;  ///< coverage of the formal interval: it fails where noise lasts
  };
  for (const Case& c :
       {Case{"white", autoregressive(0), 300, 1}, Case{"AR(1) 0.7", autoregressive(0.7), 1500, 0.75},
        Case{"AR(1) 0.95", autoregressive(0.95), 4000, 0.4}, Case{"AR(1) −0.6", autoregressive(-0.6), 1500, 1.01},
        Case{"low-passed", low_passed, 3000, 0.75}}) {
    const Coverage found = coverage(c.noise, c.samples, 600);
    EXPECT_GT(found.intercept, 0.9) << c.name;
    EXPECT_LT(found.intercept, 0.99) << c.name;
    EXPECT_GT(found.slope, 0.9) << c.name;
    EXPECT_LT(found.slope, 0.99) << c.name;
    EXPECT_LT(found.formal, c.formal_below) << c.name;
    RecordProperty(std::string(c.name), std::to_string(found.intercept) + " " + std::to_string(found.slope));
  }
}

TEST(Regression, KnowsHowManySamplesTheNoiseIsWorth) {
  test::Random random(7);
  const double phi = 0.8;
  const Eigen::VectorXd e = autoregressive(phi)(random, 200'000);
  const Regression mean = regress_mean(e);
  EXPECT_NEAR(mean.effective_samples(0) / 200'000, (1 - phi) / (1 + phi), 0.01);
  EXPECT_NEAR(mean.residual, 1 / std::sqrt(1 - phi * phi), 0.02);
  EXPECT_NEAR(mean.inflation(0), 1, 1e-12);
}

}  // namespace
}  // namespace piste
