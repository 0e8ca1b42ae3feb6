// The noise that was simulated is found from a start that is wrong.

#include "piste/tune/likeliest_noise.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <random>

#include "core/recording.h"
#include "math/linear_algebra.h"
#include "piste/core/error.h"
#include "piste/math/statistics.h"
#include "support/simulated_case.h"
#include "support/thorough.h"
#include "tune/noise_model.h"
#include "tune/noise_search.h"

namespace piste::test {
namespace {

// A run whose sensor file and receiver state other noises than were simulated.
struct WronglyTold {
  static constexpr double kGyro = 0.4, kAccel = 3, kPosition = 2, kVelocity = 0.5;  // times the true ones
  Case c;
  Log log;
  Start start;

  explicit WronglyTold(std::uint64_t seed, const std::function<void(Scenario&)>& change = {})
      : c(make_case("ski", 40, seed, change)), log(c.log()), start(c.find().start) {
    // By the user's word, as innovations alone are no reason to lower what a receiver states.
    c.options.gnss[0].white = true;
    c.options.sensor.gyro.noise *= kGyro;
    c.options.sensor.accel.noise *= kAccel;
    for (GnssFix& fix : log.gnss[0]) {
      fix.sigma_position *= kPosition;
      fix.velocity->sigma *= kVelocity;
    }
  }
  std::map<std::string, double> truth() const {  // in the units of a tuning
    return {{"gyro.noise", c.options.sensor.gyro.noise / kGyro / kDegree},
            {"accel.noise", c.options.sensor.accel.noise / kAccel * 1e6 / kStandardGravity},
            {"gnss[0].sigma_scale", 1 / kPosition},
            {"gnss[0].sigma_velocity_scale", 1 / kVelocity}};
  }
};

TEST(LikeliestNoise, IsTheOneThatWasSimulated) {
  const int runs = seeds(2, 200);
  struct Errors {
    double sum = 0, squares = 0, least = 0, most = 0;  // of ln(found / true); the squares in sigmas
    int inside = 0;
  };
  std::map<std::string, Errors> errors;
  for (int seed = 1; seed <= runs; ++seed) {
    const WronglyTold told(static_cast<std::uint64_t>(seed));
    const Tuning found = likeliest_noise(told.log, told.c.options, told.start, {.jobs = 2, .try_drift = false});
    EXPECT_GT(found.likelihood, found.likelihood_at_start + 100);
    const auto truth = told.truth();
    for (const TunedNoise& n : found.numbers) {
      EXPECT_TRUE(!n.determined || n.high < 9 * n.low) << n.name;
      if (!truth.contains(n.name)) continue;  // drifts, which a minute hardly tells
      const double error = std::log(n.value / truth.at(n.name));
      // Of the side of the interval on which the true one is: it is longer where the likelihood falls slowly.
      const double sigma = std::log(error > 0 ? n.value / n.low : n.high / n.value) / normal_quantile(0.975);
      Errors& all = errors[n.name];
      all.sum += error;
      all.squares += error * error / (sigma * sigma);
      all.least = std::min(all.least, error);
      all.most = std::max(all.most, error);
      all.inside += n.low <= truth.at(n.name) && truth.at(n.name) <= n.high ? 1 : 0;
      EXPECT_LT(std::abs(error), 4.5 * sigma) << n.name << " " << n.value << ", seed " << seed;
      EXPECT_TRUE(n.determined || n.name == "accel.noise") << n.name;  // velocities of centimetres cover that
      EXPECT_LT(std::abs(error), n.name.ends_with("scale") ? 0.1 : n.name == "gyro.noise" ? 0.5 : 2) << n.name;
    }
    // The mean of a log-normal variance, and twice the likeliest sigma at most.
    const auto by = [&](const char* name) {
      const auto n = std::ranges::find(found.numbers, name, &TunedNoise::name);
      const double sigma = std::log(n->high / n->low) / (2 * normal_quantile(0.975));
      return std::min(std::exp(sigma * sigma), 2.0);
    };
    EXPECT_NEAR(found.expected.sensor.gyro.noise / found.noise.sensor.gyro.noise, by("gyro.noise"), 1e-9);
    EXPECT_NEAR(found.expected.sensor.accel.noise / found.noise.sensor.accel.noise, by("accel.noise"), 1e-9);
    EXPECT_GT(by("accel.noise"), by("gyro.noise")) << "less is told of it";
    const WhiteNoise most = white_noise_range(told.log).most;
    EXPECT_LE(found.expected.sensor.accel.noise, most.accel);
    for (const SourceNis& source : found.nis) {
      EXPECT_GT(source.innovations, 100U);
      EXPECT_NEAR(source.mean, 1, 0.1) << source.source;
      // That of as many values of χ²₃ / 3, or a little more where they are correlated.
      EXPECT_NEAR(source.error * std::sqrt(1.5 * static_cast<double>(source.innovations)), 1.1, 0.25) << source.source;
    }
  }
  for (const auto& [name, all] : errors) {
    fmt::print("{}: {:.3f} times the true one on average, {:.2f} to {:.2f}; {} of {} inside 95 %, {:.2f} sigma rms\n",
               name, std::exp(all.sum / runs), std::exp(all.least), std::exp(all.most), all.inside, runs,
               std::sqrt(all.squares / runs));
  }
}

// At the top no number alone gains anything either way, unless it is at its limit; and the way there is short.
TEST(LikeliestNoise, ClimbsToTheTop) {
  const WronglyTold told(7);
  const NoiseModel centre = noise_model(told.c.options, told.log);
  for (const bool thorough : {true, false}) {
    const NoiseSearch search(told.log, told.c.options, told.start, centre, thorough, 2);
    const NoiseFound found = search.climb(centre);
    const std::size_t runs = search.runs();
    const JudgedLog log = search.judged(found.best.model);
    const auto n = static_cast<Eigen::Index>(found.knobs.size());
    std::vector<NoiseModel> around{found.best.model};
    for (Eigen::Index i = 0; i < n; ++i) {
      for (const double by : {-0.1, 0.1})
        around.push_back(moved(found.knobs, found.best.model, by * Eigen::VectorXd::Unit(n, i)));
    }
    const std::vector<NoisePoint> points = search.filtered(log, around);
    for (std::size_t k = 1; k < points.size(); ++k) {
      EXPECT_LT(points[k].value - points[0].value, thorough ? 0.1 : 1) << found.knobs[(k - 1) / 2].name;
    }
    EXPECT_LT(runs, thorough ? 85 : 58) << "with a run for each number in each step they were 89 and 63";
  }
}

// The ends of an interval: half of the χ² quantile below the top, or where the samples leave no more room.
TEST(LikeliestNoise, IntervalsEndWhereTheLikelihoodHasFallen) {
  const WronglyTold told(3);
  const NoiseModel centre = noise_model(told.c.options, told.log);
  const NoiseSearch search(told.log, told.c.options, told.start, centre, true, 2);
  const NoiseFound found = search.climb(centre);
  const JudgedLog log = search.judged(found.best.model);
  const Eigen::MatrixXd covariance = inverse(observed_information(search, log, found));
  const std::vector<LogInterval> intervals = likelihood_intervals(search, log, found, covariance);
  const double top = search.filtered(log, found.best.model).value, fall = 0.5 * square(normal_quantile(0.975));
  ASSERT_EQ(intervals.size(), found.knobs.size());
  for (std::size_t k = 0; k < intervals.size(); ++k) {
    const NoiseKnob& knob = found.knobs[k];
    NoiseModel best = found.best.model;
    const auto i = static_cast<Eigen::Index>(k);
    for (const double end : {intervals[k].low, intervals[k].high}) {
      NoiseModel there = moved(found.knobs, best, end / covariance(i, i) * covariance.col(i));
      const double value = knob.at(there);
      const bool at_limit = value <= knob.least * (1 + 1e-9) || value >= knob.most * (1 - 1e-9);
      // Where the others only go along it has fallen by as much at least, and by no more where they are likeliest.
      NoisePoint point = search.filtered(log, there);
      if (!at_limit) {
        EXPECT_GT(top - point.value, fall - 0.1) << knob.name << " " << end;
      }
      for (int step = 0; step < 2; ++step) point = search.climbed(log, found.knobs, {point}, {k}).front();
      EXPECT_LT(top - point.value, fall + 0.1) << knob.name << " " << end;
      if (!at_limit) {
        EXPECT_GT(top - point.value, 0.7 * fall) << knob.name << " " << end;
      }
    }
    if (knob.name == "accel.noise") {
      EXPECT_GT(intervals[k].high, -5 * intervals[k].low) << "rest tells how quiet it can be";
    }
  }
}

TEST(LikeliestNoise, HasTheSameBytesWithAnyNumberOfJobs) {
  const WronglyTold told(3, [](Scenario& s) { s.motion.run = 20; });
  const auto values = [&](std::size_t jobs) {
    std::vector<double> all;
    for (const TunedNoise& n :
         likeliest_noise(told.log, told.c.options, told.start, {.jobs = jobs, .try_drift = false, .thorough = false})
             .numbers)
      all.push_back(n.value);
    return all;
  };
  EXPECT_EQ(values(1), values(2));
}

// Fixes that come where samples of the IMU end: where their delay is estimated, all of them change over to the next
// sample and back with it, each time with the noise of another rate in the velocity of the antenna.
TEST(LikeliestNoise, DoesNotLeapWhereDelaysAreEstimated) {
  Case c = make_case("montecarlo/gentle_lap", 40, 6, [](Scenario& s) {
    s.imus[0].clock_offset = s.imus[0].clock_drift = 0;
    s.motion.run = 120;
  });
  c.options.estimate.insert(c.options.estimate.end(), {Block::kGnssDelay, Block::kClockDrift});
  const Log log = c.log();
  const NoiseModel told = noise_model(c.options, log);
  const NoiseSearch search(log, c.options, c.find().start, told, true, 2);
  const JudgedLog judged = search.judged(told);
  std::vector<NoiseModel> models;
  constexpr int kTrials = 11;
  for (int k = 0; k < kTrials; ++k) {
    models.push_back(told);
    models.back().sensor.gyro.noise *= 1 + 1e-3 * k;
  }
  const std::vector<NoisePoint> points = search.filtered(judged, models);
  for (std::size_t k = 1; k + 1 < points.size(); ++k) {
    EXPECT_NEAR(points[k - 1].value + points[k + 1].value, 2 * points[k].value, 0.01) << k;
  }
}

TEST(LikeliestNoise, FindsAColouredErrorOfPositions) {
  const auto coloured = [](double sigma) {
    return [sigma](Scenario& s) {
      s.gnss[0].position_drift = GaussMarkov{Vector3d::Constant(sigma), 20};
      s.motion.run = 120;
    };
  };
  WronglyTold white(4, [](Scenario& s) { s.motion.run = 60; });
  WronglyTold both(4, coloured(0.1));
  white.c.options.gnss[0].white = both.c.options.gnss[0].white = false;
  const TuneOptions how{.jobs = 2, .try_drift = true, .thorough = false, .stated = {Vector3d::Zero()}};
  const Tuning none = likeliest_noise(white.log, white.c.options, white.start, how);
  EXPECT_FALSE(none.noise.gnss[0].process());
  ASSERT_TRUE(none.drift_gain);
  EXPECT_LT(*none.drift_gain, none.drift_penalty);
  const Tuning found = likeliest_noise(both.log, both.c.options, both.start, how);
  ASSERT_TRUE(found.noise.gnss[0].process());
  EXPECT_GT(*found.drift_gain, found.drift_penalty);
  EXPECT_NEAR(std::log(found.noise.gnss[0].slow().x() / 0.1), 0, 0.7);
}

// A receiver that states twice the white error that its fixes show: the rest is taken to be slow, as nothing tells it.
TEST(LikeliestNoise, WhatIsStatedIsNotLowered) {
  WronglyTold told(5);
  told.c.options.gnss[0].white = false;
  const TuneOptions how{.jobs = 2, .thorough = false};
  const Tuning found = likeliest_noise(told.log, told.c.options, told.start, how);
  for (const NoiseModel* model : {&found.noise, &found.expected}) {
    const ReceiverNoise& receiver = model->gnss[0];
    EXPECT_NEAR(receiver.scales().position, 1, 1e-9);
    EXPECT_NEAR(receiver.scales().height, 1, 1e-9);
    ASSERT_TRUE(receiver.process());
    EXPECT_TRUE(receiver.process()->of_stated);
    EXPECT_NEAR(receiver.process()->sigma.x(), std::sqrt(1 - 0.25), 0.02);
    EXPECT_GE(receiver.process()->correlation_time, 20);
    EXPECT_LE(receiver.process()->correlation_time, 180);
  }
  const auto number = [&](const char* name) { return *std::ranges::find(found.numbers, name, &TunedNoise::name); };
  EXPECT_NEAR(number("gnss[0].white_scale").value, 0.5, 0.05);
  EXPECT_NEAR(number("gnss[0].sigma_scale").value, 1, 1e-9);
  EXPECT_FALSE(number("gnss[0].sigma_scale").determined);
  const double lower = number("gnss[0].sigma_velocity_scale").value;
  EXPECT_NEAR(lower, 2, 0.2) << "velocities are scaled as the innovations have it";
}

// Of an error of a minute, a minute tells how fast it walks away. How far it goes is what the receiver states.
TEST(LikeliestNoise, AnErrorThatWalksGoesAsFarAsTheReceiverStates) {
  Case c = make_case("ski", 40, 4, [](Scenario& s) {
    s.gnss[0].position_noise = {0.1, 0.1, 0.2};
    s.gnss[0].position_drift = GaussMarkov{{0.4, 0.4, 0.7}, 60};
  });
  const Log log = c.log();
  const Start start = c.find().start;
  const auto tuned = [&](double stated) {
    return likeliest_noise(log, c.options, start,
                           {.jobs = 2, .thorough = false, .stated = {Vector3d::Constant(stated)}});
  };
  const Tuning found = tuned(1);
  for (const NoiseModel* model : {&found.noise, &found.expected}) {
    const ReceiverNoise& receiver = model->gnss[0];
    ASSERT_TRUE(receiver.process());
    EXPECT_GE(receiver.position(), 1 - 1e-9);
    EXPECT_NEAR(receiver.slow().x(), 0.4, 0.05);
    EXPECT_GT(receiver.drift_time, 19);
    EXPECT_LT(receiver.drift_time, 181);
  }
  const Tuning less = tuned(0);  // stated far smaller than they are: nothing is added
  EXPECT_LT(less.expected.gnss[0].position(), 0.9);
}

// Many receivers state a sigma of heights that says nothing, such as the 100 m of a phone.
TEST(LikeliestNoise, HeightsHaveTheirOwnSigmasWhereTheyNeedThem) {
  constexpr double kHeights = 30;
  WronglyTold told(9);
  const TuneOptions how{.jobs = 2, .try_drift = false, .thorough = false};
  const Tuning even = likeliest_noise(told.log, told.c.options, told.start, how);
  EXPECT_EQ(even.noise.gnss[0].height, 1) << "they are as good as the rest";
  for (GnssFix& fix : told.log.gnss[0]) fix.sigma_position.z() *= kHeights;
  const Tuning uneven = likeliest_noise(told.log, told.c.options, told.start, how);
  EXPECT_NEAR(uneven.noise.gnss[0].height * kHeights, 1, 0.1);
  EXPECT_NEAR(uneven.noise.gnss[0].white * WronglyTold::kPosition, 1, 0.1);
  EXPECT_EQ(std::ranges::count(uneven.numbers, "gnss[0].sigma_height_scale", &TunedNoise::name), 1);
  for (const SourceNis& source : uneven.nis) EXPECT_NEAR(source.mean, 1, 0.1) << source.source;
}

// Heights in whole metres on a level road: the likelihood takes them for exact, and they are not.
TEST(LikeliestNoise, HeightsThatStandStillKeepTheErrorOfTheirRounding) {
  WronglyTold told(9, [](Scenario& s) { s.motion.slope = 0; });
  for (GnssFix& fix : told.log.gnss[0]) {
    Geodetic place = told.log.world.to_geodetic(fix.position);
    place.height = std::round(place.height);
    fix.position = told.log.world.from_geodetic(place);
  }
  const Tuning found =
      likeliest_noise(told.log, told.c.options, told.start, {.jobs = 2, .try_drift = false, .thorough = false});
  for (const NoiseModel& model : {found.noise, found.expected}) {
    const ReceiverNoise& receiver = model.gnss[0];
    ASSERT_TRUE(receiver.process());
    const double slow = receiver.process()->sigma.z(),
                 all = receiver.scales().height * receiver.scales().position * receiver.stated.z();
    EXPECT_NEAR(slow, 1 / std::sqrt(12), 1e-6);
    EXPECT_GE(std::sqrt(all * all - slow * slow), 0.5 * (1 - 1e-6)) << "of a fix, half a step";
    EXPECT_LT(receiver.process()->sigma.head<2>().maxCoeff(), 0.01);
  }
  EXPECT_EQ(std::ranges::count(found.numbers, "gnss[0].drift.sigma", &TunedNoise::name), 0) << "nothing tells it";
}

// Velocities that are noisier in what is held out change nothing of what is found; their NIS says it.
TEST(LikeliestNoise, IsJudgedByWhatIsHeldOut) {
  constexpr double kStretch = 5, kNoisier = 2;
  WronglyTold told(10);
  std::mt19937_64 random(1);
  std::normal_distribution<double> normal;
  for (GnssFix& fix : told.log.gnss[0]) {
    if (!Stretches{kStretch, true}.contain(fix.time - told.start.time)) continue;
    const double sigma = fix.velocity->sigma.x() / WronglyTold::kVelocity * std::sqrt(kNoisier * kNoisier - 1);
    fix.velocity->value += sigma * Vector3d(normal(random), normal(random), normal(random));
  }
  const TuneOptions all{.jobs = 2, .try_drift = false, .thorough = false};
  TuneOptions half = all;
  half.hold_out = kStretch;
  const auto velocities = [](const Tuning& tuning) {
    return std::ranges::find(tuning.nis, "gnss[0].velocity", &SourceNis::source);
  };
  const Tuning found = likeliest_noise(told.log, told.c.options, told.start, half);
  EXPECT_NEAR(found.noise.gnss[0].velocity * WronglyTold::kVelocity, 1, 0.15);
  EXPECT_GT(velocities(found)->mean, 2);
  EXPECT_EQ(found.held_out, kStretch);
  const Tuning both = likeliest_noise(told.log, told.c.options, told.start, all);
  EXPECT_GT(both.noise.gnss[0].velocity * WronglyTold::kVelocity, 1.3);
  EXPECT_NEAR(velocities(both)->mean, 1, 0.15);
  EXPECT_GT(10 * velocities(both)->innovations, 17 * velocities(found)->innovations);
}

TEST(LikeliestNoise, NeedsMotion) {
  WronglyTold told(5, [](Scenario& s) { s.motion.run = 20; });
  for (auto& fixes : told.log.gnss) fixes.clear();
  EXPECT_THROW(likeliest_noise(told.log, told.c.options, told.start), DataError);
}

// Fixes that are far off change little of what is found.
TEST(LikeliestNoise, IsNotThatOfOutliers) {
  WronglyTold told(6);
  const auto found = [&] {
    return likeliest_noise(told.log, told.c.options, told.start, {.jobs = 2, .try_drift = false, .thorough = false});
  };
  const Tuning clean = found();
  for (std::size_t i = 250; i < told.log.gnss[0].size(); i += 80) told.log.gnss[0][i].position.x() += 20;
  const Tuning spoilt = found();
  EXPECT_NEAR(spoilt.noise.gnss[0].white / clean.noise.gnss[0].white, 1, 0.1);
  EXPECT_NEAR(spoilt.noise.sensor.gyro.noise / clean.noise.sensor.gyro.noise, 1, 0.3);
}

// ---- What the samples themselves leave room for ----

TEST(WhiteNoiseRange, HasItsMostFromNoiseAlone) {
  constexpr double kInterval = 0.01, kGyro = 2e-3, kAccel = 0.03;
  Log log;
  std::mt19937_64 random(7);
  std::normal_distribution<double> normal;
  const auto noise = [&](double density) -> Vector3d {
    return density * std::sqrt(kInterval) * Vector3d(normal(random), normal(random), normal(random));
  };
  for (int i = 0; i < 40000; ++i) {
    ImuSample& sample = log.imu.emplace_back();
    sample.time = i * kInterval;
    sample.interval = kInterval;
    sample.dtheta = noise(kGyro);
    sample.dvel = noise(kAccel) + kInterval * Vector3d(0, 0, -9.8);
  }
  const WhiteNoise most = white_noise_range(log).most;
  EXPECT_NEAR(most.gyro / kGyro, 1, 0.03);
  EXPECT_NEAR(most.accel / kAccel, 1, 0.03);
  EXPECT_EQ(white_noise_range(log).least.gyro, 0);
  for (ImuSample& sample : log.imu) sample.at_rest = true;
  EXPECT_TRUE(std::isinf(white_noise_range(log).most.gyro));  // rest says nothing of what is under way
}

// An engine that idles shakes the samples at rest, but not their means; a person who sways does the contrary.
TEST(WhiteNoiseRange, HasItsLeastFromRestWithoutIdlingOrSwaying) {
  constexpr double kInterval = 0.01, kGyro = 2e-3, kSize = 0.2;
  for (const double hertz : {0.0, 0.3, 23.0}) {
    Log log;
    std::mt19937_64 random(7);
    std::normal_distribution<double> normal;
    for (int i = 0; i < 20000; ++i) {
      ImuSample& sample = log.imu.emplace_back();
      sample.time = i * kInterval;
      sample.interval = kInterval;
      sample.at_rest = i % 4000 < 2000;
      for (double& turned : sample.dtheta) {
        turned = kGyro * std::sqrt(kInterval) * normal(random);
        if (sample.at_rest) turned += kSize * std::sin(2 * M_PI * hertz * sample.time) * kInterval;
      }
      sample.dvel = sample.dtheta;
    }
    const WhiteNoise least = white_noise_range(log).least;
    EXPECT_GT(least.gyro / kGyro, 0.8) << hertz;
    EXPECT_LT(least.gyro / kGyro, 1) << hertz;
    EXPECT_NEAR(least.accel, least.gyro, 1e-15);
  }
}

TEST(WhiteNoiseRange, BoundsWhatIsTried) {
  const WronglyTold told(8, [](Scenario& s) { s.motion.run = 20; });
  const NoiseModel model = noise_model(told.c.options, told.log);
  const WhiteNoiseRange white = white_noise_range(told.log);
  const auto knobs = knobs_of(model, told.c.options, told.log, white);
  ASSERT_EQ(knobs.front().name, "gyro.noise");
  const auto n = static_cast<Eigen::Index>(knobs.size());
  EXPECT_DOUBLE_EQ(moved(knobs, model, 20 * Eigen::VectorXd::Unit(n, 0)).sensor.gyro.noise, white.most.gyro);
  EXPECT_GT(white.most.gyro, model.sensor.gyro.noise / WronglyTold::kGyro);
  EXPECT_DOUBLE_EQ(moved(knobs, model, -20 * Eigen::VectorXd::Unit(n, 0)).sensor.gyro.noise, white.least.gyro);
  EXPECT_GT(white.least.gyro, 0.7 * model.sensor.gyro.noise / WronglyTold::kGyro);
  EXPECT_LT(white.least.gyro, model.sensor.gyro.noise / WronglyTold::kGyro);
}

// Errors of positions that last two fixes and white ones differ by what the body does between two fixes alone: the
// noise of a vibrating IMU would be told by a receiver's smoothing.
TEST(LikeliestNoise, ErrorsOfPositionsLastFiveFixesAtLeast) {
  WronglyTold told(1);
  told.c.options.gnss[0].drift = GaussMarkov{{0.01, 0.01, 0.01}, 0.7};
  const NoiseModel model = noise_model(told.c.options, told.log);
  const auto knobs = knobs_of(model, told.c.options, told.log, white_noise_range(told.log));
  const auto time = std::ranges::find(knobs, "gnss[0].drift.correlation_time", &NoiseKnob::name);
  ASSERT_NE(time, knobs.end());
  const double interval = told.log.gnss[0][1].time - told.log.gnss[0][0].time;
  EXPECT_NEAR(time->least, 5 * interval, 1e-6);
  const auto k = static_cast<Eigen::Index>(time - knobs.begin()), n = static_cast<Eigen::Index>(knobs.size());
  EXPECT_EQ(moved(knobs, model, -9 * Eigen::VectorXd::Unit(n, k)).gnss[0].drift_time, time->least);
}

}  // namespace
}  // namespace piste::test
