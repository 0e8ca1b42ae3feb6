// The white part of a reference attitude's error, found from its fixes and the gyro, whatever the mixture.

#include "piste/solve/attitude_noise.h"

#include <gtest/gtest.h>

#include <cmath>

#include "piste/condition/pipeline.h"
#include "piste/core/state_table.h"
#include "piste/sim/simulation.h"
#include "support/scenario.h"

namespace piste::test {
namespace {

constexpr double kRadian = 1 / kDegreesPerRadian;

struct Mixture {
  Vector3d white, drift;  // deg, north, east, down
  double rest = 40;       // s before the run
};

/// What is measured of one short ski run with such a reference.
AttitudeOptions measured(const Mixture& mixture, std::uint64_t seed = 1) {
  Scenario s = read_scenario(PISTE_SOURCE_DIR "/config/scenarios/ski.yaml");
  shorten(s, mixture.rest, 20, 0);
  s.imus.resize(1);
  s.imus.front().clock_offset = s.imus.front().clock_drift = 0;
  s.gnss.resize(1);
  s.attitude.resize(1);
  s.attitude.front().noise = kRadian * mixture.white;
  s.attitude.front().drift = GaussMarkov{kRadian * mixture.drift, 60};
  const Log log = condition(simulate(s, seed).recording(0), {});
  FilterOptions options;
  const Vector3d total = kRadian * (mixture.white.cwiseAbs2() + mixture.drift.cwiseAbs2()).cwiseSqrt();
  options.attitude.push_back({.name = "", .drift = GaussMarkov{total, 60}});
  return with_white_part(options, log).attitude.front();
}

void expect_white(const AttitudeOptions& found, const Mixture& mixture, double tolerance) {
  for (int axis = 0; axis < 3; ++axis) {
    const double part = mixture.white(axis) / std::hypot(mixture.white(axis), mixture.drift(axis));
    EXPECT_NEAR(found.white(axis), part, tolerance * part) << axis;
    EXPECT_NEAR(kDegreesPerRadian * found.drift->sigma(axis), mixture.drift(axis), 0.1 * mixture.drift(axis)) << axis;
  }
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
  for (const Mixture& mixture :
       {Mixture{{0.02, 0.02, 0.02}, {0.02, 0.02, 0.04}}, Mixture{{0.01, 0.01, 0.03}, {0.03, 0.03, 0.02}},
        Mixture{{0.05, 0.05, 0.05}, {0.05, 0.05, 0.05}}}) {
    // 400 and more fixes, two of which share one: some 8 % of the sigma.
    expect_white(measured(mixture), mixture, 0.25);
  }
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
