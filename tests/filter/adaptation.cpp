// What a filter learns of noise: its sensitivity against differences of two filters, and factors against the truth.

#include "filter/adaptation.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <string_view>

#include "filter/kalman_filter.h"
#include "piste/filter/run.h"
#include "support/random.h"
#include "support/simulated_case.h"
#include "support/synthetic_log.h"
#include "trial/true_estimate.h"

namespace piste {
namespace {

using test::Case;
using test::make_case;
using test::SyntheticRun;

// A filter that adapts, but whose factors cannot leave 1, at the end of the log.
KalmanFilter filtered(const SyntheticRun& run, double gyro, double accel) {
  FilterOptions options = run.options;
  options.sensor.gyro.noise *= gyro;
  options.sensor.accel.noise *= accel;
  options.adapt = AdaptationOptions{.within = 1 + 1e-12};
  KalmanFilter filter(options, run.log.world, run.start);
  for (std::size_t r = 0; r < run.log.gnss.size(); ++r) {
    for (const GnssFix& fix : run.log.gnss[r]) filter.add(static_cast<int>(r), fix);
  }
  for (const ImuSample& sample : run.log.imu) filter.add(sample);
  filter.finish();
  return filter;
}

// M = ∂P/∂ln θ is the difference of the covariances of two filters that are told the noise a little differently.
void expect_difference_of_two_filters(SyntheticRun run, double tolerance) {
  run.options.attitude.clear();
  run.options.magnetometer.reset();
  for (GnssOptions& receiver : run.options.gnss) {
    receiver.drift.reset();
    receiver.use_velocity = false;  // what a lever arm makes of the rate's noise is no sensitivity of P
  }
  run.options.behaviour.trust.gate = 1 - 1e-15;
  const double step = 1e-3;  // of ln θ, where θ is a variance
  const KalmanFilter middle = filtered(run, 1, 1);
  for (int triad = 0; triad < 2; ++triad) {
    const auto changed = [&](double by) {
      const double factor = std::exp(0.5 * by);
      return triad == 0 ? filtered(run, factor, 1) : filtered(run, 1, factor);
    };
    const Covariance difference = (changed(step).covariance() - changed(-step).covariance()) / (2 * step);
    const Covariance& M = middle.adaptation().of_imu(triad);
    const Eigen::VectorXd sigma = M.diagonal().cwiseSqrt().cwiseMax(1e-30);
    const Eigen::MatrixXd off = (M - difference).cwiseQuotient(sigma * sigma.transpose());
    EXPECT_GT(M.topLeftCorner(9, 9).diagonal().minCoeff(), 0) << triad;
    EXPECT_LT(off.topLeftCorner(9, 9).cwiseAbs().maxCoeff(), tolerance) << triad << "\n" << off.topLeftCorner(9, 9);
  }
}

TEST(Adaptation, SensitivityIsTheDifferenceOfTwoFilters) {
  SyntheticRun run = test::synthetic_run(6, {Block::kGyroBias, Block::kAccelBias, Block::kGyroDrift});
  // What is considered moves the filters' estimates, about which they are linearised, further apart.
  expect_difference_of_two_filters(run, 0.05);
  for (TriadErrors* errors : {&run.options.sensor.gyro, &run.options.sensor.accel}) errors->scale = 0;
  run.options.sensor.accel.drift = {};
  expect_difference_of_two_filters(run, 0.02);
}

// A ride of four minutes whose filter adapts. `told`: what it is told of the noise, over the truth.
struct Told {
  double gyro = 1, position = 1, velocity = 1;
};

Case ride(std::uint64_t seed, const Told& told) {
  Case c = make_case("bicycle", 30, seed, [](Scenario& s) { s.motion.run = 240; });
  c.options.sensor.gyro.noise *= told.gyro;
  c.options.gnss[0].drift = c.scenario.gnss[0].position_drift;
  c.options.gnss[0].white = true;  // by the user's word: else its sigmas are never lowered
  c.options.adapt = AdaptationOptions{};
  return c;
}

Log log_of(const Case& c, const Told& told) {
  Log log = c.log();
  for (GnssFix& fix : log.gnss[0]) {
    fix.sigma_position *= told.position;
    fix.velocity->sigma *= told.velocity;
  }
  return log;
}

FilterRun filtered(const Case& c, const Log& log) {
  return run_filter(log, c.options, find_start(log, c.options, {}).start);
}

double factor_at(const AdaptedNoise& adapted, std::string_view name, double time) {
  const auto row = std::lower_bound(adapted.time.begin(), adapted.time.end(), time) - adapted.time.begin();
  const auto k = std::find(adapted.names.begin(), adapted.names.end(), name) - adapted.names.begin();
  return adapted.factor(static_cast<std::size_t>(row), static_cast<std::size_t>(k));
}

// Geometric mean over the second half.
double settled(const AdaptedNoise& adapted, std::string_view name) {
  const std::size_t half = adapted.time.size() / 2;
  double sum = 0;
  for (std::size_t row = half; row < adapted.time.size(); ++row) {
    sum += std::log(factor_at(adapted, name, adapted.time[row]));
  }
  return std::exp(sum / static_cast<double>(adapted.time.size() - half));
}

constexpr std::string_view kPosition = "gnss[0].position", kVelocity = "gnss[0].velocity", kGyro = "gyro_noise";

TEST(Adaptation, FindsWhatItWasToldWrongly) {
  for (const Told& told : {Told{0.5, 1, 1}, Told{2, 1.0 / 3, 1}, Told{1, 3, 0.5}}) {
    const Case c = ride(3, told);
    const AdaptedNoise adapted = filtered(c, log_of(c, told)).solution.adapted;
    const std::string what =
        fmt::format("told gyro {} position {} velocity {}", told.gyro, told.position, told.velocity);
    EXPECT_NEAR(std::log(settled(adapted, kPosition) * told.position), 0, 0.06) << what;
    EXPECT_NEAR(std::log(settled(adapted, kVelocity) * told.velocity), 0, 0.06) << what;
    EXPECT_NEAR(std::log(settled(adapted, kGyro) * told.gyro), 0, 0.35) << what;  // what some 100 s can tell
  }
}

// Innovations show the white part of what a receiver states, so that they are no reason to lower it.
TEST(Adaptation, NeverLowersPositionsUnlessTheirErrorsAreWhite) {
  const Told told{1, 3, 0.5};
  Case c = ride(3, told);
  c.options.gnss[0].white = false;
  const AdaptedNoise adapted = filtered(c, log_of(c, told)).solution.adapted;
  EXPECT_GE(settled(adapted, kPosition), 1);
  EXPECT_LT(settled(adapted, kPosition), 1.01);
  EXPECT_NEAR(std::log(settled(adapted, kVelocity) * told.velocity), 0, 0.1) << "velocities are learned all the same";
}

TEST(Adaptation, FollowsAReceiverThatGetsWorseAndBetter) {
  const Case c = ride(4, {});
  Log log = c.log();
  test::Random random(7);
  const double from = c.under_way() + 100, until = from + 60;
  for (GnssFix& fix : log.gnss[0]) {
    if (fix.time > from && fix.time < until) fix.position += random.vector(1).cwiseProduct(6 * fix.sigma_position);
  }
  const AdaptedNoise adapted = filtered(c, log).solution.adapted;
  EXPECT_NEAR(factor_at(adapted, kPosition, from - 1), 1, 0.2);
  EXPECT_GT(factor_at(adapted, kPosition, from + 10), 4);
  EXPECT_NEAR(factor_at(adapted, kPosition, until - 1), 6, 1.2);
  EXPECT_LT(factor_at(adapted, kPosition, until + 30), 1.4);
  EXPECT_NEAR(factor_at(adapted, kVelocity, until - 1), 1, 0.3);
}

// An offset that stays is no noise: its fixes remain outside the gate.
TEST(Adaptation, AnOffsetIsNoNoise) {
  const Case c = ride(5, {});
  Log log = c.log();
  const double from = c.under_way() + 100, until = from + 20;
  for (GnssFix& fix : log.gnss[0]) {
    if (fix.time > from && fix.time < until) fix.position += Vector3d(3, -4, 2);
  }
  const FilterRun run = filtered(c, log);
  EXPECT_LT(factor_at(run.solution.adapted, kPosition, until - 1), 1.6);
  for (const Innovation& v : run.solution.innovations) {
    if (v.source != 0 || v.time < from + 0.05 || v.time > until - 0.05) continue;
    EXPECT_FALSE(was_used(v.outcome)) << v.time - from;
  }
}

// The mean squared error of velocity in its sigmas, a row, over the second half.
double nees_of_velocity(const Case& c, const Log& log, std::uint64_t seed) {
  const TrueEstimate truth(c.scenario, c.simulation, log.world, seed);
  const FilterRun run = filtered(c, log);
  const Solution& s = run.solution;
  double sum = 0, count = 0;
  for (std::size_t i = s.size() / 2; i < s.size(); i += 100) {
    if (s.time(i) > c.under_way() + c.scenario.motion.run - 5) break;
    const Vector3d error =
        log.world.rotation_wn(s.estimate(i).p_wb).transpose() * (s.estimate(i).v_wb - truth.at(s.time(i)).v_wb);
    sum += error.cwiseQuotient(s.sigmas(i).velocity).squaredNorm();
    count += 3;
  }
  return sum / count;
}

TEST(Adaptation, SigmasAreFarNearerTheTruth) {
  const Told told{1, 0.25, 0.25};
  double adapted = 0, stated = 0;
  constexpr int kRuns = 2;
  for (std::uint64_t seed = 1; seed <= kRuns; ++seed) {
    Case c = ride(seed, told);
    const Log log = log_of(c, told);
    adapted += nees_of_velocity(c, log, seed) / kRuns;
    c.options.adapt.reset();
    stated += nees_of_velocity(c, log, seed) / kRuns;
  }
  EXPECT_GT(stated, 6);
  EXPECT_LT(adapted, 2.2);  // not 1: the first seconds were filtered as stated
}

TEST(Adaptation, OffItKeepsNothing) {
  const SyntheticRun run = test::synthetic_run(3, {});
  const KalmanFilter filter(run.options, run.log.world, run.start);
  EXPECT_FALSE(filter.adaptation().on());
  EXPECT_EQ(filter.adaptation().variance_of(0), 1);
  EXPECT_TRUE(run_filter(run.log, run.options, run.start).solution.adapted.names.empty());
}

// What stands still for long is believed as stated again.
TEST(Adaptation, ForgetsTowardsWhatIsStated) {
  SyntheticRun run = test::synthetic_run(3, {});
  run.options.adapt = AdaptationOptions{.within = 10, .time = 50, .imu_time = 50};
  const MeasurementSources sources(run.options);
  const StateLayout layout(run.options.estimate);
  Adaptation adaptation(run.options, layout, sources);
  Linearization lin;
  lin.covariance = Matrix3d::Identity();
  lin.residual = Vector3d(3, -2, 2.5);
  const Update u = innovate(Covariance::Zero(layout.size(), layout.size()), layout, lin);
  for (int i = 0; i < 50; ++i) adaptation.learn(0, 100 + 0.1 * i, u, 100);
  const double learned = adaptation.variance_of(0);
  EXPECT_GT(learned, 3);
  adaptation.learn(1, 400, u, 100);  // another source, five minutes later
  EXPECT_NEAR(adaptation.variance_of(0), 1, 0.05);
}

}  // namespace
}  // namespace piste
