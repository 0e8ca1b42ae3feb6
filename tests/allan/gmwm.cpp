// The generalised method of wavelet moments: its intervals over simulated recordings, and recorded curves.

#include "piste/allan/gmwm.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <sstream>
#include <vector>

#include "piste/allan/sensor_noise.h"
#include "piste/core/error.h"
#include "piste/math/statistics.h"
#include "piste/math/units.h"
#include "support/datasets.h"
#include "support/random.h"
#include "support/thorough.h"

namespace piste {
namespace {

// White noise of density 1, a Gauss-Markov process, and a random walk if it is asked for; samples of 1 s.
std::vector<double> simulated(test::Random& random, std::size_t count, double sigma, double time,
                              double walk_density = 0) {
  std::vector<double> x(count);
  const double decay = std::exp(-1 / time), driven = sigma * std::sqrt(1 - decay * decay);
  double markov = random.gaussian(sigma), walk = 0;
  for (double& v : x) {
    v = random.gaussian() + markov + walk;
    markov = decay * markov + random.gaussian(driven);
    if (walk_density > 0) walk += random.gaussian(walk_density);
  }
  return x;
}

// Within three sigmas of what 95 % give over so many recordings.
void expect_covers(int inside, int runs, const std::string& what) {
  const double share = static_cast<double>(inside) / runs, sigma = std::sqrt(0.95 * 0.05 / runs);
  fmt::print("{}: {:.3f} of {}\n", what, share, runs);
  EXPECT_NEAR(share, 0.95, 3 * sigma) << what;
}

TEST(Gmwm, IntervalsCoverWhatTheyClaim) {
  const int runs = test::seeds(150, 1000);
  constexpr double kSigma = 0.5, kTime = 60, kWalk = 0.004;
  test::Random random(12);
  int white = 0, sigma = 0, time = 0, density = 0, walk = 0;
  for (int run = 0; run < runs; ++run) {
    {
      const GmwmFit fit = fit_gmwm(allan_curve(simulated(random, 1 << 14, kSigma, kTime), 1),
                                   {.model = {ProcessKind::kWhite, ProcessKind::kGaussMarkov}});
      const auto inside = [](double value, double low, double high) { return low <= value && value <= high ? 1 : 0; };
      const FittedProcess &w = *fit.find(ProcessKind::kWhite), &m = *fit.find(ProcessKind::kGaussMarkov);
      white += inside(1, w.low, w.high);
      sigma += inside(kSigma, m.low, m.high);
      time += inside(kTime, m.low_time, m.high_time);
    }
    {
      const GmwmFit fit = fit_gmwm(allan_curve(simulated(random, 1 << 14, 1e-9, kTime, kWalk), 1),
                                   {.model = {ProcessKind::kWhite, ProcessKind::kRandomWalk}});
      const FittedProcess &w = *fit.find(ProcessKind::kWhite), &r = *fit.find(ProcessKind::kRandomWalk);
      density += w.low <= 1 && 1 <= w.high ? 1 : 0;
      walk += r.low <= kWalk && kWalk <= r.high ? 1 : 0;
    }
  }
  expect_covers(white, runs, "white noise beside Gauss-Markov");
  expect_covers(sigma, runs, "size of Gauss-Markov");
  expect_covers(time, runs, "its correlation time");
  expect_covers(density, runs, "white noise beside a random walk");
  expect_covers(walk, runs, "random walk");
}

// The model is chosen: what was put in is found, and what was not is rarely taken up.
TEST(Gmwm, ChoosesTheModelThatWasSimulated) {
  const int runs = test::seeds(20, 100);
  test::Random random(5);
  int white = 0, markov = 0, fits = 0;
  for (int run = 0; run < runs; ++run) {
    std::vector<double> x(1 << 13);
    for (double& v : x) v = random.gaussian();
    const GmwmFit alone = fit_gmwm(allan_curve(x, 1));
    white += alone.name() == "white noise" ? 1 : 0;
    fits += alone.fits() ? 1 : 0;
    markov +=
        fit_gmwm(allan_curve(simulated(random, 1 << 15, 0.5, 60), 1)).name() == "white noise + Gauss-Markov" ? 1 : 0;
  }
  EXPECT_GE(white, runs * 8 / 10);
  EXPECT_GE(fits, runs * 9 / 10);
  EXPECT_GE(markov, runs * 7 / 10);
}

TEST(Gmwm, TellsWhatACurveCannotDetermine) {
  test::Random random(2);
  const GmwmFit fit = fit_gmwm(allan_curve(simulated(random, 2000, 1e-9, 60, 1e-4), 1));
  const auto unseen = std::find_if(fit.unseen.begin(), fit.unseen.end(),
                                   [](const UnseenProcess& u) { return u.kind == ProcessKind::kRandomWalk; });
  ASSERT_NE(unseen, fit.unseen.end());
  EXPECT_GT(unseen->below, 1e-4);
  EXPECT_LT(unseen->below, 0.1);
}

TEST(Gmwm, RefusesWhatHasNoNoise) {
  EXPECT_THROW(fit_gmwm(allan_curve(std::vector<double>(1000, 3.0), 1)), DataError);
  EXPECT_THROW(fit_gmwm(allan_curve(std::vector<double>{1, 2, 3, 1, 2, 5}, 1)), DataError);
}

TEST(Gmwm, RobustFitDoesNotFollowOutliers) {
  test::Random random(9);
  std::vector<double> x(1 << 14);
  for (double& v : x) v = random.gaussian();
  for (std::size_t i = 0; i < x.size(); i += 400) x[i] += 60;
  const AllanCurve curve = allan_curve(x, 1, true);
  const std::vector<ProcessKind> white{ProcessKind::kWhite};
  EXPECT_GT(fit_gmwm(curve, {.model = white}).find(ProcessKind::kWhite)->process.size, 2);
  EXPECT_NEAR(fit_gmwm(curve, {.robust = true, .model = white}).find(ProcessKind::kWhite)->process.size, 1, 0.1);
}

// White noise alone. One curve in twenty is refused at 0.05 by chance: that is no misfit, and does not move its noise.
TEST(Gmwm, AMisfitByChanceDoesNotMoveTheNoise) {
  test::Random random(31);
  int refused = 0;
  for (int run = 0; run < 60; ++run) {
    std::vector<double> x(1 << 15);
    for (double& v : x) v = random.gaussian(10);
    const AllanCurve curve = allan_curve(x, 0.01);  // of density 1
    const GmwmFit fit = fit_gmwm(curve, {.model = {ProcessKind::kWhite}});
    if (fit.model_error > 0) ++refused;
    const Measured noise = axis_noise(fit, curve).noise;
    EXPECT_LT(std::abs(std::log(noise.value)), 4 * noise.sigma_log) << run << ": " << noise.value;
  }
  EXPECT_GT(refused, 0);
}

// The curve of an LN200 at rest for six hours, as its recordists published it: angle random walk.
TEST(Gmwm, AngleRandomWalkOfAnLn200) {
  PISTE_REQUIRE_DATASETS();
  std::ifstream file(test::datasets() / "allan" / "ln200_av.csv");
  std::string line;
  std::getline(file, line);
  constexpr double kInterval = 1.0 / 400;
  constexpr std::size_t kSamples = 6 * 3600 * 400;
  AllanCurve curves[3];
  for (AllanCurve& c : curves) {
    c.interval = kInterval;
    c.lengths = {kSamples};
  }
  while (std::getline(file, line)) {
    std::istringstream words(line);
    std::string word;
    std::vector<double> row;
    while (std::getline(words, word, ',')) row.push_back(std::stod(word));
    const auto m = static_cast<std::size_t>(std::llround(row[0] / kInterval));
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const double deviation = row[1 + 3 * axis];
      curves[axis].scales.push_back({m, kSamples - 2 * m + 1, deviation * deviation, deviation * deviation});
    }
  }
  // Without a model: the mean of the deviation times √τ from 1 to 100 s, over which it falls as that of white noise. Of
  // the first axis it is 1.198e-5, of the others 1.116e-5 and 1.104e-5.
  const double lowest[] = {1.19e-5, 1.05e-5, 1.05e-5}, highest[] = {1.205e-5, 1.15e-5, 1.15e-5};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const AllanCurve& curve = curves[axis];
    double sum = 0, weights = 0, times = 0, slope = 0;
    for (const AllanScale& scale : curve.scales) {
      const double tau = static_cast<double>(scale.samples) * kInterval;
      if (tau < 1 || tau > 100) continue;
      const double weight = static_cast<double>(kSamples) / static_cast<double>(scale.samples) - 1;
      sum += weight * std::log(scale.variance * tau) / 2;
      times += weight * std::log(tau);
      weights += weight;
    }
    double squares = 0;
    for (const AllanScale& scale : curve.scales) {
      const double tau = static_cast<double>(scale.samples) * kInterval;
      if (tau < 1 || tau > 100) continue;
      const double weight = static_cast<double>(kSamples) / static_cast<double>(scale.samples) - 1;
      slope += weight * (std::log(tau) - times / weights) * std::log(scale.variance) / 2;
      squares += weight * square(std::log(tau) - times / weights);
    }
    EXPECT_NEAR(slope / squares, -0.5, 0.005);
    const double direct = std::exp(sum / weights);
    const AxisNoise noise = axis_noise(fit_gmwm(curve), curve);
    fmt::print("angle random walk {:.4g} ({:.3g} to {:.3g}), without a model {:.4g} rad/sqrt(s)\n", noise.noise.value,
               noise.noise.low, noise.noise.high, direct);
    EXPECT_NEAR(noise.noise.value / direct, 1, 0.01);
    EXPECT_GT(noise.noise.value, lowest[axis]);
    EXPECT_LT(noise.noise.value, highest[axis]);
  }
}

}  // namespace
}  // namespace piste
