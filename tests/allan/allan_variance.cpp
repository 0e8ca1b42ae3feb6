// The Allan variance against certified values, against its definition, and where logs have holes.

#include "piste/allan/allan_variance.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <vector>

#include "piste/allan/noise_process.h"
#include "support/random.h"

namespace piste {
namespace {

// The test series of NIST SP 1065: a multiplicative congruential generator.
std::vector<double> nist_series(std::size_t count) {
  std::vector<double> out;
  std::uint64_t n = 1234567890;
  for (std::size_t i = 0; i < count; ++i) {
    out.push_back(static_cast<double>(n) / 2147483647.0);
    n = 16807 * n % 2147483647;
  }
  return out;
}

std::vector<double> random_series(std::size_t count, std::uint64_t seed) {
  test::Random random(seed);
  std::vector<double> out(count);
  for (double& v : out) v = random.gaussian();
  return out;
}

double by_definition(const std::vector<double>& x, std::size_t m) {
  double sum = 0;
  std::size_t terms = 0;
  for (std::size_t k = 0; k + 2 * m <= x.size(); ++k, ++terms) {
    double first = 0, second = 0;
    for (std::size_t i = 0; i < m; ++i) {
      first += x[k + i];
      second += x[k + m + i];
    }
    const double difference = (second - first) / static_cast<double>(m);
    sum += difference * difference;
  }
  return sum / (2 * static_cast<double>(terms));
}

// Riley 2008, NIST SP 1065, tables 31 and 32, and between its scales `allantools.oadev(x, rate=1, data_type="freq",
// taus=[1, 2, 4, …])` of allantools 2024.6.
TEST(AllanVariance, IsThatOfNist) {
  const AllanCurve nine = allan_curve(std::vector<double>{892, 809, 823, 798, 671, 644, 883, 903, 677}, 1);
  EXPECT_NEAR(std::sqrt(nine.scales[0].variance), 91.22945, 1e-5);
  EXPECT_NEAR(std::sqrt(nine.scales[1].variance), 85.95287, 1e-5);
  const AllanCurve thousand = allan_curve(nist_series(1000), 1);
  const std::vector<double> deviation{0.2922318781,  0.2010160422,  0.1447913072,  0.1057038501, 0.06191477842,
                                      0.04808214262, 0.03623721299, 0.02767385582, 0.01028221764};
  ASSERT_GE(thousand.scales.size(), deviation.size());
  for (std::size_t i = 0; i < deviation.size(); ++i) {
    EXPECT_EQ(thousand.scales[i].samples, std::size_t{1} << i);
    EXPECT_NEAR(std::sqrt(thousand.scales[i].variance), deviation[i], 1e-9) << i;
  }
}

TEST(AllanVariance, IsItsDefinitionInPiecesAndWithAnOffset) {
  std::vector<double> x = random_series(3000, 4);
  for (double& v : x) v += 1e5;
  AllanSums sums;
  for (std::size_t i = 0; i < x.size(); i += 7) {
    sums.add(std::span(x).subspan(i, std::min<std::size_t>(7, x.size() - i)));
  }
  sums.end_stretch();
  const AllanCurve curve = sums.curve(0.01);
  EXPECT_EQ(curve.samples(), x.size());
  for (const AllanScale& s : curve.scales) {
    EXPECT_NEAR(s.variance / by_definition(x, s.samples), 1, 1e-6) << s.samples;
    EXPECT_EQ(s.terms, x.size() - 2 * s.samples + 1);
    EXPECT_DOUBLE_EQ(s.wavelet(), s.variance / 2);
  }
}

// No difference is taken across the end of a stretch.
TEST(AllanVariance, DoesNotReachOverAGap) {
  const std::vector<double> a = random_series(500, 1), b = random_series(700, 2);
  AllanSums sums;
  std::vector<double> shifted = b;
  for (double& v : shifted) v += 1000;
  sums.add(a);
  sums.end_stretch();
  sums.add(shifted);
  sums.end_stretch();
  const AllanCurve both = sums.curve(1);
  const std::vector<AllanCurve> each{allan_curve(a, 1), allan_curve(b, 1)};
  const AllanCurve together = pooled(each);
  for (std::size_t i = 0; i < 8; ++i) {
    EXPECT_NEAR(both.scales[i].variance / together.scales[i].variance, 1, 1e-6) << i;
    EXPECT_EQ(both.scales[i].terms, together.scales[i].terms);
  }
}

// What large clusters skip changes nothing that counts.
TEST(AllanVariance, LargeClustersByEverySecondSumAreAsGood) {
  const std::vector<double> x = random_series(1 << 14, 3);
  constexpr int kFew = 6;
  AllanSums coarse(false, kFew);
  coarse.add(x);
  coarse.end_stretch();
  const AllanCurve all = allan_curve(x, 1), some = coarse.curve(1);
  ASSERT_EQ(all.scales.size(), some.scales.size());
  for (std::size_t i = 0; i < all.scales.size(); ++i) {
    const bool skips = i > kFew;
    EXPECT_NEAR(some.scales[i].variance / all.scales[i].variance, 1, skips ? 0.05 : 1e-9) << i;
  }
}

TEST(AllanVariance, RobustVarianceDoesNotFollowOutliers) {
  std::vector<double> x = random_series(20000, 5);
  for (std::size_t i = 0; i < x.size(); i += 500) x[i] += 100;
  const AllanCurve curve = allan_curve(x, 1, true);
  EXPECT_GT(curve.scales[0].variance, 5);
  EXPECT_NEAR(curve.scales[0].robust, 1, 0.05);
}

// The closed form of every process, and the covariance of the estimates, against the mean over simulated series.
TEST(NoiseProcess, VariancesAndTheirCovarianceAreThoseOfSimulations) {
  constexpr std::size_t kCount = 512;
  constexpr int kRuns = 600;
  constexpr double kTime = 20;
  const std::vector<NoiseProcess> model{{ProcessKind::kWhite, 1, 0},
                                        {ProcessKind::kGaussMarkov, 0.5, kTime},
                                        {ProcessKind::kRandomWalk, 0.02, 0},
                                        {ProcessKind::kQuantisation, 0.4, 0}};
  test::Random random(8);
  Eigen::MatrixXd values;
  AllanCurve last;
  for (int run = 0; run < kRuns; ++run) {
    std::vector<double> x(kCount);
    const double decay = std::exp(-1 / kTime);
    double markov = random.gaussian(0.5), walk = 0, rounded = random.gaussian(0.4);
    for (double& v : x) {
      const double next = random.gaussian(0.4);
      v = random.gaussian() + markov + walk + next - rounded;
      rounded = next;
      markov = decay * markov + random.gaussian(0.5 * std::sqrt(1 - decay * decay));
      walk += random.gaussian(0.02);
    }
    last = allan_curve(x, 1);
    if (run == 0) values.resize(kRuns, static_cast<Eigen::Index>(last.scales.size()));
    for (Eigen::Index i = 0; i < values.cols(); ++i) values(run, i) = last.scales[static_cast<std::size_t>(i)].variance;
  }
  const Eigen::RowVectorXd mean = values.colwise().mean();
  const Eigen::MatrixXd centred = values.rowwise() - mean, covariance = centred.transpose() * centred / (kRuns - 1);
  const Eigen::MatrixXd claimed = allan_covariance(model, last);
  for (Eigen::Index i = 0; i < values.cols(); ++i) {
    const double expected = allan_variance(model, last.scales[static_cast<std::size_t>(i)].samples, 1);
    const double sigma = std::sqrt(claimed(i, i) / kRuns);
    EXPECT_NEAR(mean(i), expected, 4 * sigma) << i;
    // A variance of kRuns values is known to √(2/kRuns), wider where values are far from normal.
    EXPECT_NEAR(covariance(i, i) / claimed(i, i), 1, i + 2 < values.cols() ? 0.3 : 0.8) << i;
    for (Eigen::Index j = 0; j < i; ++j) {
      const double scale = std::sqrt(claimed(i, i) * claimed(j, j));
      EXPECT_NEAR((covariance(i, j) - claimed(i, j)) / scale, 0, 0.25) << i << ' ' << j;
    }
  }
}

}  // namespace
}  // namespace piste
