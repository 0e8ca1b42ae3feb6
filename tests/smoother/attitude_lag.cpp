#include "piste/smoother/attitude_lag.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <vector>

namespace piste {
namespace {

using CorrelationOfLag = std::function<double(double lag)>;

// Pairs over 400 s, sigmas of 1 to 3 mrad that change from epoch to epoch.
std::vector<AttitudeLag> lags(const CorrelationOfLag& level, const CorrelationOfLag& heading) {
  const auto sigma = [](int i) { return Vector3d(1e-3, 2e-3, 1e-3 * (2 + std::sin(i))); };
  std::vector<AttitudeLag> all;
  for (int late = 0; late <= 400; late += 25) {
    for (int early = 0; early <= late; early += 2) {
      const double lag = late - early;
      const Vector3d a = sigma(early), b = sigma(late);
      AttitudeLag l{.early = static_cast<std::size_t>(early),
                    .late = static_cast<std::size_t>(late),
                    .lag = lag,
                    .covariance = Matrix3d::Zero(),
                    .of_early = Matrix3d::Zero(),
                    .of_late = Matrix3d::Zero()};
      l.of_early.diagonal() = a.cwiseAbs2();
      l.of_late.diagonal() = b.cwiseAbs2();
      l.covariance.diagonal() = a.cwiseProduct(b).cwiseProduct(Vector3d(level(lag), level(lag), heading(lag)));
      all.push_back(l);
    }
  }
  return all;
}

CorrelationOfLag gauss_markov(double tau) {
  return [tau](double lag) { return std::exp(-lag / tau); };
}

TEST(AttitudeLag, AGaussMarkovErrorHasItsOwnTime) {
  for (const double tau : {3.0, 25.0, 60.0, 170.0, 350.0}) {
    EXPECT_NEAR(correlation_time(lags(gauss_markov(tau), gauss_markov(tau))) / tau, 1, 1e-3) << tau;
  }
}

TEST(AttitudeLag, OneTimeForLevelAndHeading) {
  const double tau = correlation_time(lags(gauss_markov(200), gauss_markov(20)));
  EXPECT_GT(tau, 20);
  EXPECT_LT(tau, 200);
  EXPECT_GT(tau, correlation_time(lags(gauss_markov(20), gauss_markov(200))));  // level counts twice
}

TEST(AttitudeLag, AnErrorThatStaysHasTheLongestLag) {
  const CorrelationOfLag stays = [](double) { return 1.0; };
  EXPECT_EQ(correlation_time(lags(stays, stays)), 400);
}

// Half of it fades in a few seconds and half stays: neither alone is the answer.
TEST(AttitudeLag, AnErrorOfTwoParts) {
  const CorrelationOfLag both = [](double lag) { return 0.5 + 0.5 * std::exp(-lag / 5); };
  const double tau = correlation_time(lags(both, both));
  EXPECT_GT(tau, 100);
  EXPECT_LE(tau, 400);
}

TEST(AttitudeLag, NothingIsSaidOfNothing) {
  EXPECT_EQ(correlation_time({}), 0);
  EXPECT_EQ(correlation_time(std::vector{lags(gauss_markov(5), gauss_markov(5)).front()}), 0);  // no lag
}

}  // namespace
}  // namespace piste
