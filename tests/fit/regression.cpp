// Certified values and standard errors of NIST, and intervals that hold the truth as often as they say.

#include "piste/fit/regression.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <Eigen/SVD>
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
  for (const auto& set : {test::pontius(), test::wampler(1), test::wampler(2), test::wampler(3), test::wampler(4),
                          test::wampler(5), test::filip()}) {
    const int order = static_cast<int>(set.value.size()) - 1;
    expect_certified(set, regress_polynomial(set.X.col(1), set.y, order), 9, 7);
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

TEST(Regression, APolynomialIsThatOfThePowers) {
  const auto set = test::pontius();
  const Regression general = regress(set.X, set.y), polynomial = regress_polynomial(set.X.col(1), set.y, 2);
  for (int i = 0; i < 3; ++i) {
    EXPECT_NEAR(polynomial.inflation(i) / general.inflation(i), 1, 1e-9);
    EXPECT_NEAR(polynomial.hac_covariance(i, i) / general.hac_covariance(i, i), 1, 1e-6);
    EXPECT_NEAR(polynomial.correlation(0, i), general.correlation(0, i), 1e-9);
  }
  EXPECT_DOUBLE_EQ(regress_polynomial(set.X.col(1), set.y, 0).value(0), regress_mean(set.y).value(0));
}

TEST(Regression, SeveralSeriesOnTheSameColumnsAreEachAsAlone) {
  test::Random random(3);
  const Eigen::MatrixXd X = random.matrix(100, 3), Y = random.matrix(100, 2);
  const auto each = regress_each(X, Y);
  ASSERT_EQ(each.size(), 2U);
  for (Eigen::Index k = 0; k < 2; ++k) {
    const Regression alone = regress(X, Y.col(k)), &found = each[static_cast<std::size_t>(k)];
    EXPECT_EQ(found.value, alone.value);
    EXPECT_EQ(found.hac_covariance, alone.hac_covariance);
    EXPECT_EQ(found.residual, alone.residual);
  }
}

// An error that is one of the cosines is all of one average; one beyond them is in none.
TEST(Regression, TheLongRunVarianceIsTheMeanOfSquaredCosineAverages) {
  static constexpr Eigen::Index n = 600;
  const auto covariance = [](int j) {
    Eigen::VectorXd y(n);
    for (Eigen::Index t = 0; t < n; ++t) y(t) = 3 + std::cos(3.14159265358979 * j * (static_cast<double>(t) + 0.5) / n);
    const Regression mean = regress_mean(y);
    EXPECT_NEAR(mean.value(0), 3, 1e-12);
    EXPECT_EQ(mean.dof, 12);
    return mean.hac_covariance(0, 0);
  };
  for (const int j : {1, 5, 12}) EXPECT_NEAR(covariance(j), 600.0 / 599 / 24, 1e-9) << j;
  EXPECT_NEAR(covariance(13), 0, 1e-12);
}

// Mean and intercept at the first sample of one signal with noise of 1 s at 10 Hz: their difference is zero, and in
// its 95 % interval as often as that says. Taken as independent the two give an interval that holds it always.
TEST(Regression, ThePairedDifferenceOfTwoEstimatesHoldsAsOftenAsItSays) {
  constexpr int kRuns = 400;
  constexpr Eigen::Index n = 500;
  const Eigen::VectorXd x = Eigen::VectorXd::LinSpaced(n, -0.3, 1.7);
  int paired = 0, independent = 0;
  double widest = 0;
  for (int run = 0; run < kRuns; ++run) {
    test::Random random(100 + static_cast<std::uint64_t>(run));
    Eigen::VectorXd y(n);
    double noise = random.gaussian();
    const double keeps = std::exp(-0.1 / 1.0);
    for (Eigen::Index t = 0; t < n; ++t) {
      y(t) = 5 + noise;
      noise = keeps * noise + std::sqrt(1 - keeps * keeps) * random.gaussian();
    }
    const Term a = regress_mean(y).term(0), b = regress_line(x, y).term(0);
    const Term both = paired_difference(a, b), apart = difference(a, b);
    EXPECT_EQ(both.value, a.value - b.value);
    EXPECT_NEAR(both.dof, 12, 1e-9);
    if (std::abs(both.value) < both.half_width(0.95)) ++paired;
    if (std::abs(apart.value) < apart.half_width(0.95)) ++independent;
    widest = std::max(widest, both.standard_error);
    EXPECT_NEAR(both.averages.norm(), both.standard_error, 1e-12);
  }
  EXPECT_NEAR(paired / static_cast<double>(kRuns), 0.95, 0.03);
  EXPECT_GT(independent / static_cast<double>(kRuns), 0.98);
}

TEST(Regression, APairedDifferenceHasWhatIsNotShared) {
  Term a{.value = 3, .standard_error = 5, .dof = 12, .systematic = 13};
  Term b{.value = 1, .standard_error = 10, .dof = 12, .systematic = 5};
  EXPECT_DOUBLE_EQ(paired_difference(a, b).standard_error, difference(a, b).standard_error);
  EXPECT_DOUBLE_EQ(paired_difference(a, b).systematic, std::hypot(13, 5));
  a.averages = Eigen::Vector2d(0, 3);  // the remaining 4, of another source
  b.averages = Eigen::Vector2d(6, 8);
  a.effects = Eigen::Vector2d(5, 12);
  b.effects = Eigen::Vector2d(3, 4);
  const Term both = paired_difference(a, b);
  EXPECT_DOUBLE_EQ(both.standard_error, std::sqrt(16 + 36 + 25));
  EXPECT_DOUBLE_EQ(both.systematic, std::hypot(2, 8));
  a = b;
  a.value += 1e-12;
  EXPECT_EQ(paired_difference(a, b).p_value(), 1) << "of one estimate from itself there is only rounding";
}

// Total least squares: the line along the largest singular vector of the centred and scaled points.
TEST(Regression, BothNoisyIsTotalLeastSquaresWhereNoiseIsScaledToTheSame) {
  test::Random random(11);
  for (const double ratio : {1e-3, 0.25, 1.0, 9.0, 1e4}) {
    for (const double slope : {-3.0, -0.2, 0.7, 5.0}) {
      const Eigen::VectorXd truth = 2 * random.matrix(80, 1);
      const Eigen::VectorXd x = truth.array() + 4 + 0.3 * random.matrix(80, 1).array();
      const Eigen::VectorXd y = slope * truth.array() - 1 + 0.3 * std::sqrt(ratio) * random.matrix(80, 1).array();
      Eigen::MatrixXd points(80, 2);
      points << (x.array() - x.mean()) * std::sqrt(ratio), y.array() - y.mean();
      const Eigen::Vector2d along = points.jacobiSvd(Eigen::ComputeThinV).matrixV().col(0);
      const double expected = std::sqrt(ratio) * along(1) / along(0);
      const Regression line = regress_both_noisy(x, y, ratio);
      EXPECT_NEAR(line.value(1), expected, 1e-11 * std::abs(expected)) << ratio << " " << slope;
      EXPECT_NEAR(line.value(0), y.mean() - expected * x.mean(), 1e-9 * std::abs(expected));
      // Seen from the other side it is the same line.
      const Regression other = regress_both_noisy(y, x, 1 / ratio);
      EXPECT_NEAR(other.value(1) * line.value(1), 1, 1e-12);
      EXPECT_NEAR(other.term(1).sigma, line.term(1).sigma / (line.value(1) * line.value(1)),
                  1e-9 * line.term(1).sigma / (line.value(1) * line.value(1)));
    }
  }
}

// The moments of the data are m_xx = s + u, m_xy = b s, m_yy = b² s + ratio u, with s the variance of the true x and u
// that of its noise, and the variance of b is that of Fuller 1987, section 1.3: (s v + u v − (b u)²) / ((n − 2) s²), v
// of e.
TEST(Regression, BothNoisyHasTheFormalVarianceOfFuller) {
  test::Random random(13);
  for (const double ratio : {0.1, 1.0, 20.0}) {
    const Eigen::Index n = 50;
    const Eigen::VectorXd x = random.matrix(n, 1), y = 2 * x + 2 * random.matrix(n, 1);
    const double b = regress_both_noisy(x, y, ratio).value(1);
    const Eigen::ArrayXd dx = x.array() - x.mean(), dy = y.array() - y.mean();
    const double s = (dx * dy).mean() / b, u = dx.square().mean() - s, v = ratio * u + b * b * u;
    EXPECT_NEAR(dy.square().mean(), b * b * s + ratio * u, 1e-12);
    const double expected = (s * v + u * v - b * b * u * u) / (static_cast<double>(n - 2) * s * s);
    EXPECT_NEAR(regress_both_noisy(x, y, ratio).covariance(1, 1) / expected, 1, 1e-10) << ratio;
  }
}

TEST(Regression, BothNoisyGoesToEitherRegression) {
  const auto set = test::norris();
  const Eigen::VectorXd x = set.X.col(1), &y = set.y;
  const Regression direct = regress_line(x, y), inverse = regress_line(y, x);
  const Regression all_y = regress_both_noisy(x, y, 1e12), all_x = regress_both_noisy(x, y, 1e-12);
  EXPECT_TRUE(all_y.value.isApprox(direct.value, 1e-10));
  EXPECT_TRUE(all_y.covariance.isApprox(direct.covariance, 1e-5));
  EXPECT_TRUE(all_y.hac_covariance.isApprox(direct.hac_covariance, 1e-5));
  EXPECT_NEAR(all_y.residual, direct.residual, 1e-9);
  EXPECT_NEAR(all_y.inflation(1), direct.inflation(1), 1e-9);
  EXPECT_NEAR(all_x.value(1), 1 / inverse.value(1), 1e-10);
  EXPECT_THROW(regress_both_noisy(x, Eigen::VectorXd::Ones(36), 1), DataError);
  EXPECT_THROW(regress_both_noisy(Eigen::VectorXd::Ones(36), y, 1), DataError);
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

Eigen::VectorXd swinging(Eigen::Index n) {
  Eigen::VectorXd x(n);
  for (Eigen::Index i = 0; i < n; ++i) {
    const auto t = static_cast<double>(i);
    x(i) = 1 + 3 * std::sin(0.01 * t) + std::sin(0.043 * t);
  }
  return x;
}

struct Coverage {
  double intercept = 0, slope = 0, formal = 0;  ///< shares of 95 % intervals that hold the truth
};

Coverage coverage(const Noise& noise, Eigen::Index n, int runs) {
  Coverage out;
  const Eigen::VectorXd x = swinging(n);
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

// x is as noisy as half the motion: the line on it is flat by var / (var + noise), the inverted one of x on y steep by
// what the noise of y is to the motion, and the truth is what Deming's interval holds.
TEST(Regression, BothNoisyHoldsTheTruthWhereEitherRegressionIsWrong) {
  struct Case {
    const char* name;
    Noise noise;
    double formal_above, formal_below;  ///< coverage of the formal interval
  };
  constexpr int kRuns = 400;
  constexpr double kX = 0.8, kY = 1.2;  // deviations of the noise
  const Eigen::VectorXd truth = swinging(2000);
  const double variance = (truth.array() - truth.mean()).square().mean();
  for (const Case& c : {Case{"white", autoregressive(0), 0.92, 0.98}, Case{"AR(1) 0.8", autoregressive(0.8), 0, 0.8},
                        Case{"low-passed", low_passed, 0, 0.8}}) {
    test::Random long_draw(1);
    const double deviation = std::sqrt(c.noise(long_draw, 200'000).squaredNorm() / 200'000);
    double intercept = 0, slope = 0, formal = 0, direct = 0, inverse = 0, both = 0;
    for (int run = 0; run < kRuns; ++run) {
      test::Random random(static_cast<std::uint64_t>(run) + 1);
      const Eigen::VectorXd x = truth + kX / deviation * c.noise(random, truth.size());
      const Eigen::VectorXd y = 0.5 + (2 * truth + kY / deviation * c.noise(random, truth.size())).array();
      const Regression line = regress_both_noisy(x, y, kY * kY / (kX * kX));
      const Term b = line.term(0), k = line.term(1);
      intercept += std::abs(b.value - 0.5) < b.half_width(0.95);
      slope += std::abs(k.value - 2) < k.half_width(0.95);
      formal += std::abs(k.value - 2) < 1.96 * k.sigma;
      direct += regress_line(x, y).value(1);
      inverse += 1 / regress_line(y, x).value(1);
      both += k.value;
    }
    EXPECT_GT(intercept / kRuns, 0.9) << c.name;
    EXPECT_LT(intercept / kRuns, 0.99) << c.name;
    EXPECT_GT(slope / kRuns, 0.9) << c.name;
    EXPECT_LT(slope / kRuns, 0.99) << c.name;
    EXPECT_GT(formal / kRuns, c.formal_above) << c.name << ", Fuller's variance";
    EXPECT_LT(formal / kRuns, c.formal_below) << c.name;
    EXPECT_NEAR(both / kRuns, 2, 0.01) << c.name;
    EXPECT_NEAR(direct / kRuns, 2 * variance / (variance + kX * kX), 0.02) << c.name;
    EXPECT_NEAR(inverse / kRuns, (4 * variance + kY * kY) / (2 * variance), 0.02) << c.name;
    RecordProperty(std::string("both noisy, ") + c.name,
                   fmt::format("{} {} {}", intercept / kRuns, slope / kRuns, formal / kRuns));
  }
}

TEST(Regression, PolynomialsHoldTheTruthUnderNoiseThatLasts) {
  const Eigen::Index n = 3000;
  const Eigen::VectorXd x = swinging(n);
  const Eigen::Vector4d truth(0.5, 2, -0.1, 0.03);
  Eigen::Vector4d inside = Eigen::Vector4d::Zero();
  constexpr int kRuns = 400;
  for (int run = 0; run < kRuns; ++run) {
    test::Random random(static_cast<std::uint64_t>(run) + 1);
    const Eigen::ArrayXd a = x.array();
    const Eigen::VectorXd y =
        truth(0) + a * (truth(1) + a * (truth(2) + a * truth(3))) + autoregressive(0.9)(random, n).array();
    const Regression found = regress_polynomial(x, y, 3);
    for (int j = 0; j < 4; ++j) {
      const Term t = found.term(j);
      inside(j) += std::abs(t.value - truth(j)) < t.half_width(0.95);
    }
  }
  for (int j = 0; j < 4; ++j) {
    EXPECT_GT(inside(j) / kRuns, 0.9) << j;
    EXPECT_LT(inside(j) / kRuns, 0.99) << j;
  }
}

TEST(Regression, KnowsHowManySamplesTheNoiseIsWorth) {
  test::Random random(7);
  const double phi = 0.8;
  constexpr int kSeries = 400, kSamples = 2000;
  double worth = 0, square = 0;
  for (int i = 0; i < kSeries; ++i) {
    const Regression mean = regress_mean(autoregressive(phi)(random, kSamples));
    worth += kSamples / mean.effective_samples(0) / kSeries;
    square += mean.residual * mean.residual / kSeries;
    EXPECT_NEAR(mean.inflation(0), 1, 1e-12);
  }
  // Each is known to 1 / sqrt(6), that of twelve averages.
  EXPECT_NEAR(worth * (1 - phi) / (1 + phi), 1, 4 / std::sqrt(6.0 * kSeries));
  EXPECT_NEAR(square * (1 - phi * phi), 1, 0.02);
}

// A Gauss-Markov error over a hundred of its correlation times, sampled seldom or often: intervals of a mean and of a
// line hold what they say.
TEST(Regression, IntervalsDoNotDependOnTheSampleRate) {
  constexpr int kRuns = 1500;
  for (const double samples_in_tau : {1.0, 2.5, 10.0, 40.0, 100.0}) {
    const auto n = static_cast<Eigen::Index>(100 * samples_in_tau);
    const Noise noise = autoregressive(std::exp(-1 / samples_in_tau));
    Eigen::VectorXd x(n);
    for (Eigen::Index i = 0; i < n; ++i) x(i) = std::sin(0.5 * static_cast<double>(i) / samples_in_tau);
    double mean = 0, slope = 0;
    test::Random random(11);
    for (int run = 0; run < kRuns; ++run) {
      const Eigen::VectorXd e = noise(random, n);
      const Term m = regress_mean(e).term(0), k = regress_line(x, e).term(1);
      mean += std::abs(m.value) < m.half_width(0.95);
      slope += std::abs(k.value) < k.half_width(0.95);
    }
    EXPECT_NEAR(mean / kRuns, 0.95, 0.02) << samples_in_tau;
    EXPECT_NEAR(slope / kRuns, 0.95, 0.02) << samples_in_tau;
    RecordProperty(fmt::format("{} samples", samples_in_tau), fmt::format("{} {}", mean / kRuns, slope / kRuns));
  }
}

}  // namespace
}  // namespace piste
