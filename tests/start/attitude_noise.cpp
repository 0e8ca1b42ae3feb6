// The white part of a reference attitude's error, found from its fixes and the gyro, whatever the mixture.

#include "piste/start/attitude_noise.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <vector>

#include "piste/condition/pipeline.h"
#include "piste/math/units.h"
#include "piste/sim/simulation.h"
#include "support/places.h"
#include "support/scenario.h"
#include "support/thorough.h"

namespace piste::test {
namespace {

struct Mixture {
  Vector3d white, drift;  // deg, north, east, down
  double rest = 40;       // s before the run
};

/// What is measured of one short ski run with such a reference, its log and what is known of it changed before.
AttitudeOptions measured(const Mixture& mixture, std::uint64_t seed = 1, const std::function<void(Log&)>& change = {},
                         const std::function<void(AttitudeOptions&)>& know = {},
                         const std::vector<Block>& estimate = {}) {
  Scenario s = read_scenario(source_folder() + "/config/scenarios/ski.yaml");
  shorten(s, mixture.rest, 20, 0);
  s.imus.resize(1);
  s.imus.front().clock_offset = s.imus.front().clock_drift = 0;
  s.gnss.resize(1);
  s.attitude.resize(1);
  s.attitude.front().noise = kDegree * mixture.white;
  s.attitude.front().drift = GaussMarkov{kDegree * mixture.drift, 60};
  Log log = condition(simulate(s, seed).recording(0), {});
  if (change) change(log);
  FilterOptions options;
  const Vector3d total = kDegree * (mixture.white.cwiseAbs2() + mixture.drift.cwiseAbs2()).cwiseSqrt();
  options.attitude.push_back({.name = "", .drift = GaussMarkov{total, 60}});
  options.estimate = estimate;
  options.priors.attitude_delay = 0.1;
  if (know) know(options.attitude.front());
  return with_white_part(options, log).attitude.front();
}

TEST(AttitudeSigmas, AreTheRmsOfTheFixesLevelAxesAlike) {
  FilterOptions options;
  options.attitude = {{.name = "coloured", .drift = GaussMarkov{Vector3d::Zero(), 60}}, {.name = "white", .drift = {}}};
  const AttitudeRecording fixes{.file = "",
                                .fixes = {{0, Vector3d::Zero(), {0.3, 0.4, 3}}, {1, Vector3d::Zero(), {0.5, 0, 4}}}};
  const FilterOptions known = with_attitude_sigmas(options, {fixes, fixes});
  EXPECT_TRUE(known.attitude[0].drift->sigma.isApprox(Vector3d(std::sqrt(0.125), std::sqrt(0.125), std::sqrt(12.5))));
  EXPECT_FALSE(known.attitude[1].drift);
}

TEST(WhitePart, IsFoundWhateverTheMixture) {
  const int runs = seeds(2, 20);
  for (const Mixture& mixture :
       {Mixture{{0.02, 0.02, 0.02}, {0.02, 0.02, 0.04}}, Mixture{{0.01, 0.01, 0.03}, {0.03, 0.03, 0.02}},
        Mixture{{0.05, 0.05, 0.05}, {0.05, 0.05, 0.05}}}) {
    Vector3d white = Vector3d::Zero(), drift = white;
    for (int seed = 1; seed <= runs; ++seed) {
      const AttitudeOptions found = measured(mixture, static_cast<std::uint64_t>(seed));
      white += found.white / runs;
      drift += kDegreesPerRadian * found.drift->sigma / runs;
    }
    // 400 and more fixes, two of which share one: some 8 % of the sigma in one run.
    const double tolerance = 3.3 * 0.08 / std::sqrt(runs);
    for (int axis = 0; axis < 3; ++axis) {
      const double part = mixture.white(axis) / std::hypot(mixture.white(axis), mixture.drift(axis));
      EXPECT_NEAR(white(axis) / part, 1, tolerance) << axis;
      // drift² = total² − white²: an error of the white part comes in by the ratio of both variances.
      const double ratio = std::pow(mixture.white(axis) / mixture.drift(axis), 2);
      EXPECT_NEAR(drift(axis) / mixture.drift(axis), 1, 0.02 + ratio * tolerance) << axis;
    }
  }
}

// A fix that leaps, and gyro samples that clip, are no noise.
TEST(WhitePart, OutliersAndClippedSamplesAreLeftOut) {
  const Mixture mixture{{0.02, 0.02, 0.02}, {0.02, 0.02, 0.04}};
  const Vector3d clean = measured(mixture).white;
  const AttitudeOptions spoilt = measured(mixture, 1, [](Log& log) {
    for (std::size_t k = 20; k < log.attitude[0].size(); k += 50) {
      log.attitude[0][k].q_wr = so3_exp(Vector3d(0.02, -0.03, 0.01)) * log.attitude[0][k].q_wr;
    }
    for (std::size_t i = 1000; i < log.imu.size(); i += 300) {
      log.imu[i].dtheta.x() += 0.01;
      log.imu[i].clipped_gyro = 1;
    }
  });
  for (int axis = 0; axis < 3; ++axis) EXPECT_NEAR(spoilt.white(axis) / clean(axis), 1, 0.15) << axis;
}

// Local level is that of the receiver's fixes, and of the origin where there are none: a run is small.
TEST(WhitePart, NeedsNoFixOfAReceiverEverywhere) {
  const Mixture mixture{{0.01, 0.01, 0.03}, {0.03, 0.03, 0.02}};
  const Vector3d whole = measured(mixture).white;
  const Vector3d half = measured(mixture, 1, [](Log& log) { log.gnss[0].resize(log.gnss[0].size() / 2); }).white;
  const Vector3d none = measured(mixture, 1, [](Log& log) { log.gnss[0].clear(); }).white;
  EXPECT_LT((half - whole).norm(), 1e-3);
  EXPECT_LT((none - whole).norm(), 1e-3);
}

TEST(WhitePart, FixesFarApartTellNothing) {
  const auto rare = [](Log& log) {
    double next = 0;
    std::erase_if(log.attitude[0], [&](const AttitudeFix& f) {
      if (f.time < next) return true;
      next = f.time + 1.5;
      return false;
    });
  };
  EXPECT_EQ(measured({{0.05, 0.05, 0.05}, {0.01, 0.01, 0.01}, 400}, 1, rare).white, AttitudeOptions{}.white);
}

// White by what the configuration says: nothing is to be measured, and nothing changed.
TEST(WhitePart, ASourceWithoutDriftIsLeftAsItIs) {
  const AttitudeOptions found = measured({{0.05, 0.05, 0.05}, {0.05, 0.05, 0.05}}, 1, {},
                                         [](AttitudeOptions& options) { options.drift.reset(); });
  EXPECT_FALSE(found.drift);
  EXPECT_EQ(found.white, AttitudeOptions{}.white);
}

// With a reference that is late by a fifth of a second not even the mounting is found, unless its delay is estimated.
TEST(WhitePart, ADelayThatIsEstimatedIsFoundFirst) {
  const Mixture mixture{{0.02, 0.02, 0.02}, {0.02, 0.02, 0.04}};
  const auto late = [](Log& log) {
    for (AttitudeFix& fix : log.attitude[0]) fix.time += 0.2;
  };
  const Vector3d right = measured(mixture).white, found = measured(mixture, 1, late, {}, {Block::kAttitudeDelay}).white;
  EXPECT_EQ(measured(mixture, 1, late).white, AttitudeOptions{}.white);
  for (int axis = 0; axis < 3; ++axis) EXPECT_NEAR(found(axis) / right(axis), 1, 0.25) << axis;
}

TEST(WhitePart, AllOrATenth) {
  const AttitudeOptions all = measured({{0.05, 0.05, 0.05}, {1e-4, 1e-4, 1e-4}});
  EXPECT_GT(all.white.minCoeff(), 0.85);
  EXPECT_GT(all.drift->sigma.minCoeff(), 0);
  const AttitudeOptions little = measured({{1e-4, 1e-4, 1e-4}, {0.05, 0.05, 0.05}});
  EXPECT_LT(little.white.maxCoeff(), 0.15);
  EXPECT_GE(little.white.minCoeff(), 0.1);
}

TEST(WhitePart, ATenthWhereThereIsTooLittle) {
  const AttitudeOptions found = measured({{0.05, 0.05, 0.05}, {0.01, 0.01, 0.01}, 2});
  EXPECT_EQ(found.white, Vector3d::Constant(0.1));
}

}  // namespace
}  // namespace piste::test
