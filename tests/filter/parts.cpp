// The small parts of the filter, each by its law: noise of a sample, rest updates, readmission, the start's covariance.

#include <gtest/gtest.h>

#include "filter/covariance_inflation.h"
#include "filter/filter_walk.h"
#include "piste/filter/initial_state.h"
#include "support/blocks.h"
#include "support/random.h"
#include "support/synthetic_log.h"
#include "walker/rest_updates.h"
#include "walker/sample_noise.h"

namespace piste {
namespace {

ImuSensor sensor() {
  ImuSensor s;
  s.gyro = {.noise = 0.01,
            .bias = 0.002,
            .drift = {.kind = DriftProcess::Kind::kGaussMarkov, .sigma = 0.1, .correlation_time = 50},
            .scale = 0.01,
            .range = 5};
  s.accel = {.noise = 0.02,
             .bias = 0.03,
             .drift = {.kind = DriftProcess::Kind::kRandomWalk, .density = 1e-4},
             .scale = 0.02,
             .range = 20};
  return s;
}

// What n clipped samples in a row hide is one error: as a sum over the run its variance is n² that of a single one.
TEST(SampleNoise, ClippedSamplesInARowAreOneError) {
  const double own = 0.01 * 0.01, dt = 0.01;
  ImuSample clipped{.time = 0, .interval = dt, .dtheta = {0, 5 * dt, 0}, .dvel = {0, 0, 0}};
  clipped.clipped_gyro = 0b010;
  SampleNoise noise;
  const auto still = [&](int count) {  // so that the share of clipped samples stays
    for (int i = 0; i < count; ++i)
      noise.of({.time = 0, .interval = dt, .dtheta = {0, 0, 0}, .dvel = {0, 0, 0}}, sensor());
  };
  constexpr int kMany = 1000000;
  still(kMany);
  for (int i = 0; i < 9999; ++i) noise.of(clipped, sensor());
  still(1);
  const double one = (noise.of(clipped, sensor()).noise.gyro.y() - own) * dt;
  const HiddenExcess expected = hidden_excess(5, 0.0495, 10000.0 / 1010000);
  EXPECT_NEAR(one, expected.variance * dt * dt, 1e-3 * one);
  double sum = one;
  for (int n = 2; n <= 5; ++n) {
    const ClippedNoise now = noise.of(clipped, sensor());
    EXPECT_EQ(now.noise.gyro.x(), own) << "another axis";
    EXPECT_NEAR(now.hidden_rate.y(), expected.mean, 1e-3 * expected.mean);
    EXPECT_EQ(now.hidden_rate.x(), 0);
    EXPECT_TRUE(now.hidden_force.isZero(0));
    sum += (now.noise.gyro.y() - own) * dt;
    EXPECT_NEAR(sum, n * n * one, 1e-3 * sum) << n;
  }
  still(1);
  EXPECT_NEAR((noise.of(clipped, sensor()).noise.gyro.y() - own) * dt, one, 1e-3 * one) << "begins anew";
}

// What it states of the hidden part of a clipped signal is that part's mean and variance, at both ends.
TEST(SampleNoise, HiddenPartsOfANormalSignalHaveTheStatedMeanAndVariance) {
  const double dt = 0.01, range = 5;
  for (const auto& [sigma, mean] : {std::pair{2.0, 0.0}, {3.0, 0.5}, {1.6, -1.5}}) {
    test::Random random(5);
    SampleNoise noise;
    const auto take = [&](double value) {
      const double shown = std::clamp(value, -range, range);
      ImuSample sample{.time = 0, .interval = dt, .dtheta = {0, 0, shown * dt}, .dvel = {0, 0, 0}};
      sample.clipped_gyro = std::abs(value) > range ? 0b100 : 0;
      return noise.of(sample, sensor());
    };
    double sum = 0, squares = 0, count = 0;
    for (int i = 0; i < 200000; ++i) {
      const double value = mean + random.gaussian(sigma);
      const ClippedNoise stated = take(value);
      if (i < 20000 || std::abs(value) <= range) continue;
      const double left = value - std::copysign(range, value) - stated.hidden_rate.z();
      const double variance = (stated.noise.gyro.z() - 0.01 * 0.01) / dt;
      sum += left / std::sqrt(variance);
      squares += left * left / variance;
      ++count;
      take(mean);  // the next one is not in a row with it
    }
    EXPECT_GT(count, 500);
    EXPECT_NEAR(sum / count, 0, 0.1) << sigma << " " << mean;
    EXPECT_NEAR(squares / count, 1, 0.15) << sigma << " " << mean;
  }
}

TEST(SampleNoise, AGapAddsItsOwn) {
  ImuSample filled{.time = 0, .interval = 0.01, .dtheta = {0, 0, 0}, .dvel = {0, 0, 0}};
  filled.gap = GapNoise{.gyro = 0.25, .accel = 0.5};
  const StepNoise noise = SampleNoise().of(filled, sensor()).noise;
  EXPECT_TRUE(noise.gyro.isApproxToConstant(0.01 * 0.01 + 0.25 * 0.25));
  EXPECT_TRUE(noise.accel.isApproxToConstant(0.02 * 0.02 + 0.5 * 0.5));
}

TEST(RestUpdates, GiveTheMeanRateOfAnIntervalWithoutMotionOrGap) {
  const RestOptions options{.interval = 0.5};
  RestUpdates rest;
  ImuSample sample{.time = 0, .interval = 0.1, .dtheta = {0.01, 0, 0}, .dvel = {0, 0, 0}};
  const auto next = [&](bool at_rest, bool gap) {
    sample.time += 0.1;
    sample.at_rest = at_rest;
    sample.gap = gap ? std::optional(GapNoise{}) : std::nullopt;
    return rest.add(sample, options);
  };
  for (int i = 0; i < 3; ++i) EXPECT_FALSE(next(true, false));
  EXPECT_FALSE(next(false, false)) << "it moved";
  for (int i = 0; i < 3; ++i) EXPECT_FALSE(next(true, false));
  EXPECT_FALSE(next(true, true)) << "nothing was measured";
  for (int round = 0; round < 2; ++round) {
    for (int i = 0; i < 4; ++i) EXPECT_FALSE(next(true, false)) << round;
    const std::optional<RestFix> fix = next(true, false);
    ASSERT_TRUE(fix) << round;
    EXPECT_EQ(fix->time, sample.time);
    EXPECT_NEAR(fix->duration, 0.5, 1e-12);
    EXPECT_NEAR(fix->mean_gyro.x(), 0.1, 1e-12);
  }
}

// Whatever is admitted explains the residual: over the lapse, the position's own part, the velocity's and the tilt's
// are each as large as it.
TEST(RestUpdates, AreWithdrawnAfterAsManyRefusalsAsTheOptionsSay) {
  for (const int patience : {1, 3}) {
    RestUpdates rest;
    for (int i = 0; i < patience; ++i) {
      EXPECT_FALSE(rest.withdrawn());
      rest.judge(false, {.patience = patience});
    }
    EXPECT_TRUE(rest.withdrawn());
  }
}

TEST(Readmission, AdmitsWhatExplainsTheResidual) {
  const StateLayout layout;
  Linearization lin;
  lin.residual = {3, 0, 4};
  Covariance P = Covariance::Zero(9, 9);
  inflate_covariance(P, layout, lin, 10, {});
  EXPECT_NEAR(P(0, 0), 25, 1e-12);
  EXPECT_NEAR(P(3, 3) * 10 * 10, 25, 1e-12);
  EXPECT_NEAR(P(6, 6) * std::pow(kStandardGravity * 10 * 10 / 2, 2), 25, 1e-9);

  lin.observes = Block::kVelocity;
  P.setZero();
  inflate_covariance(P, layout, lin, 10, {});
  EXPECT_EQ(P(0, 0), 0);
  EXPECT_NEAR(P(3, 3), 25, 1e-12);
  EXPECT_NEAR(P(6, 6) * std::pow(kStandardGravity * 10, 2), 25, 1e-9);

  P.setZero();
  inflate_covariance(P, layout, lin, 0.5, {});
  EXPECT_NEAR(P(6, 6), 0.2 * 0.2, 1e-12) << "no more than a tilt of 0.2 rad";
  P.setZero();
  inflate_covariance(P, layout, lin, std::numeric_limits<double>::infinity(), {});
  EXPECT_EQ(P(6, 6), 0) << "the start's own error is no tilt";
}

// One of several IMUs has a new offset, and nobody knows which: neither the attitude nor anything else has.
TEST(Readmission, AdmitsADriftWhereSeveralImusPart) {
  const std::array blocks{Block::kAccelDrift, parity_block(Block::kAccelDrift, 0), parity_block(Block::kAccelDrift, 1),
                          Block::kGyroDrift};
  const StateLayout layout(blocks);
  Linearization lin;
  lin.observes = parity_block(Block::kAccelDrift, 1);
  lin.residual = {0.5, 0, -0.1};
  Covariance P = Covariance::Zero(layout.size(), layout.size());
  inflate_covariance(P, layout, lin, 10, {});
  Eigen::VectorXd expected = Eigen::VectorXd::Zero(layout.size());
  for (const Block block : {Block::kAccelDrift, parity_block(Block::kAccelDrift, 1)}) {
    expected.segment<3>(layout.offset(block)) = Vector3d(0.25, 0, 0.01);
  }
  EXPECT_LT((P.diagonal() - expected).norm(), 1e-12);
}

// Every block that a layout names starts with what the table knows of it; none with nothing, unless it is a walk.
TEST(InitialCovariance, IsTheTables) {
  FilterOptions options;
  options.sensor = sensor();
  options.gnss.resize(1);
  options.gnss[0].drift = GaussMarkov{{1, 2, 3}, 60};
  options.attitude.resize(1);
  options.attitude[0].drift = GaussMarkov{{0.1, 0.2, 0.3}, 60};
  options.attitude[0].boresight_drift = GaussMarkov{{0.4, 0.5, 0.6}, 9};
  const StateLayout layout(test::most_blocks());
  Start start{0, {}, 7 * Covariance::Identity(9, 9)};
  const Covariance P = initial_covariance(layout, options, start);
  const auto sigma = [&](Block b, int axis) { return std::sqrt(P(layout.offset(b) + axis, layout.offset(b) + axis)); };
  EXPECT_EQ((P.block<6, 6>(3, 3)), (7 * Eigen::Matrix<double, 6, 6>::Identity()));
  EXPECT_DOUBLE_EQ(sigma(Block::kGyroBias, 1), 0.002);
  EXPECT_DOUBLE_EQ(sigma(Block::kAccelBias, 2), 0.03);
  EXPECT_DOUBLE_EQ(sigma(Block::kGyroDrift, 0), 0.1);
  EXPECT_EQ(sigma(Block::kAccelDrift, 0), 0) << "a walk starts at the turn-on bias";
  EXPECT_DOUBLE_EQ(sigma(Block::kAccelScale, 0), 0.02);
  EXPECT_DOUBLE_EQ(sigma(Block::kBoresight, 0), options.priors.boresight);
  EXPECT_DOUBLE_EQ(sigma(Block::kGnssDelay, 0), options.priors.gnss_delay);
  EXPECT_DOUBLE_EQ(sigma(Block::kClockDrift, 0), options.priors.clock_drift);
  EXPECT_DOUBLE_EQ(sigma(Block::kGnssPositionDrift, 2), 3);
  EXPECT_DOUBLE_EQ(sigma(Block::kAttitudeDrift, 1), 0.2);
  EXPECT_DOUBLE_EQ(sigma(Block::kBoresightDrift, 0), 0.4);

  // The start knows where the antenna is; attitude and lever arm, which it does not, part it from the IMU.
  test::Random random(3);
  start.x.q_wb = random.estimate().q_wb;
  start.x.lever_arm = {0.3, -0.2, 0.9};
  start.covariance.topLeftCorner<3, 3>() *= 1e-6;
  const Covariance apart = initial_covariance(layout, options, start);
  Eigen::MatrixXd antenna = Eigen::MatrixXd::Zero(3, layout.size());  // by the state
  antenna.leftCols<3>().setIdentity();
  antenna.middleCols<3>(6) = -skew(start.x.R_wb() * start.x.lever_arm);
  antenna.middleCols<3>(layout.offset(Block::kLeverArm)) = start.x.R_wb();
  EXPECT_TRUE((antenna * apart * antenna.transpose()).isApprox(7e-6 * Matrix3d::Identity(), 1e-6));
  EXPECT_NEAR((antenna * apart).rightCols(layout.size() - 3).norm(), 0, 1e-9) << "and tells neither";
}

struct LastStep : Unrecorded {
  Transition step;
  void add_step(const Transition& t) { step = t; }
};

// The scales of a body that stands see the mean of what gravity reads on its axes, whatever the noise of the
// accelerometers does to the attitude of single epochs; and no rate at all.
TEST(Predict, ABodyThatStandsReadsMeanGravity) {
  const World world({0.8, 0.1, 500});
  FilterOptions options;
  options.sensor = sensor();
  options.estimate.clear();
  options.behaviour.rest.interval = 10;  // longer than the test, which wants no updates
  KalmanFilter filter(options, world, Start{});
  LastStep last;
  FilterWalk walk(filter, last);
  const Vector3d gravity = world.gravity(Vector3d::Zero()).value;
  const auto sample = [&](int i, double turn, bool rest) {
    return ImuSample{
        .time = 0.01 * i, .interval = 0.01, .dtheta = {turn, 0, 0}, .dvel = -0.01 * gravity, .at_rest = rest};
  };
  Vector3d sum = Vector3d::Zero();
  walk.add(sample(1, -0.01, true));
  for (int i = 1; i <= 50; ++i) {
    ASSERT_TRUE(walk.add(i < 50 ? sample(i + 1, i % 2 ? 0.01 : -0.01, true) : sample(51, 0.02, false)));
    sum -= filter.estimate().q_wb.conjugate() * gravity;
    EXPECT_LT((last.step.force - sum / i).norm(), 1e-9) << i;
    EXPECT_EQ(last.step.rate, Vector3d::Zero());
  }
  walk.finish();
  EXPECT_GT(last.step.rate.x(), 1) << "it moves";
}

TEST(World, GravityFollowsTheBody) {
  const World world({0.8, 0.1, 500});
  Gravity gravity = world.gravity(Vector3d::Zero());
  for (double north = 0; north < 3000; north += 10) {
    const Vector3d here = {north, 0, 0};
    world.follow(gravity, here);
    EXPECT_LT((gravity.at(here) - world.gravity(here).value).norm(), 5e-9) << north;
  }
}

}  // namespace
}  // namespace piste
