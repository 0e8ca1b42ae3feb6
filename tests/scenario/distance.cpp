// A run far from the origin of its world frame: the same recordings, conditioned in a world with its origin at the run
// and in one with its origin 900 km away, give the same values, sigmas and innovations.

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <functional>
#include <limits>

#include "piste/replay/replay.h"
#include "piste/start/attitude_noise.h"
#include "support/simulated_case.h"
#include "support/solutions_apart.h"

namespace piste::test {
namespace {

using Source = InitialHeading::Source;

struct DistanceCase {
  const char* name;
  InitialHeading heading = {};
  std::function<void(Scenario&)> scenario = [](Scenario&) {};
  std::function<void(Case&)> options = [](Case&) {};
  bool down = true;     // whether the velocities have it
  bool moving = false;  // whether the log begins under way
};

void PrintTo(const DistanceCase& kind, std::ostream* out) { *out << kind.name; }

Apart innovations_apart(const Solution& far, const Solution& near) {
  Apart a;
  EXPECT_EQ(far.innovations.size(), near.innovations.size());
  std::size_t otherwise = 0;
  for (std::size_t i = 0; i < std::min(far.innovations.size(), near.innovations.size()); ++i) {
    const Innovation &v = far.innovations[i], &w = near.innovations[i];
    if (v.source != w.source || v.outcome != w.outcome) ++otherwise;
    a.add((v.residual - w.residual).head(w.dof), v.sigma.head(w.dof), w.sigma.head(w.dof));
  }
  EXPECT_EQ(otherwise, 0u) << "fixes that were judged otherwise";
  return a;
}

class Distance : public ::testing::TestWithParam<DistanceCase> {};

TEST_P(Distance, ChangesNeitherValuesNorSigmas) {
  const DistanceCase& kind = GetParam();
  Case c = make_case("ski", 75, 3, [&](Scenario& s) {
    s.motion.run = 50;
    s.gnss[0].position_noise = {0.2, 0.4, 1.5};  // so that it matters along which axes they are
    s.gnss[0].velocity_noise = {0.05, 0.1, 0.4};
    kind.scenario(s);
  });
  kind.options(c);
  if (kind.moving) c.conditioning.span = {c.under_way() + 8.3, c.under_way() + 50};
  Recording recording = c.simulation.recording(0);
  for (GeodeticFix& fix : recording.gnss[0].fixes) {
    if (kind.down) continue;
    fix.velocity->value.z() = 0;
    fix.velocity->sigma.z() = std::numeric_limits<double>::infinity();
  }
  const ReplayOptions options{.filter = with_attitude_sigmas(c.options, recording.attitude), .heading = kind.heading};
  const Geodetic place = recording.gnss[0].fixes[0].position;
  const World elsewhere({place.latitude - 0.1, place.longitude + 0.13, 0});
  ASSERT_NEAR(elsewhere.from_geodetic(place).norm(), 9e5, 5e4);

  const Replay near = replay(condition(recording, c.conditioning), options);
  const Replay far = replay(condition(recording, c.conditioning, elsewhere), options);
  ASSERT_GT(near.smoothed->size(), 3000u);
  constexpr double kSame = 1e-4;  // of a sigma
  const auto expect_same = [&](const char* what, const Apart& a) {
    fmt::print("{}, {}: values {:.1e} sigma apart, sigmas {:.1e} of themselves\n", kind.name, what, a.value, a.sigma);
    EXPECT_LT(a.value, kSame) << what;
    EXPECT_LT(a.sigma, kSame) << what;
  };
  expect_same("filtered", apart(far.filtered.solution, near.filtered.solution));
  expect_same("smoothed", apart(*far.smoothed, *near.smoothed));
  expect_same("innovations", innovations_apart(far.filtered.solution, near.filtered.solution));
  EXPECT_NEAR(far.smoothed->attitude_correlation_time, near.smoothed->attitude_correlation_time, 1e-3);
}

void with_drift(Case& c) {
  c.options.gnss[0].drift = GaussMarkov{{0.1, 0.2, 0.7}, 60};
  c.options.estimate.push_back(Block::kGnssPositionDrift);
}

void with_reference(Scenario& s) { s.attitude = read_scenario(s.file).attitude; }

void with_boresight(Case& c) {
  c.options.attitude[0].drift = c.scenario.attitude[0].drift;
  c.options.estimate.push_back(Block::kBoresight);
  c.options.estimate.push_back(Block::kAttitudeDrift);
}

void with_magnetometer(Scenario& s) {
  s.imus[0].magnetic_field = Vector3d(22, 0, 42);
  s.imus[0].magnetometer.sigma = 0.5;
}

INSTANTIATE_TEST_SUITE_P(All, Distance,
                         ::testing::Values(DistanceCase{.name = "Motion", .options = with_drift},
                                           DistanceCase{.name = "Moving", .moving = true},
                                           DistanceCase{.name = "WithoutDown", .down = false},
                                           DistanceCase{.name = "Reference",
                                                        .heading = {Source::kAttitude},
                                                        .scenario = with_reference,
                                                        .options = with_boresight},
                                           DistanceCase{.name = "Magnetometer",
                                                        .heading = {Source::kMagnetometer},
                                                        .scenario = with_magnetometer,
                                                        .options =
                                                            [](Case& c) {
                                                              c.options.magnetometer.emplace();
                                                              c.options.estimate =
                                                                  with_implied_blocks(c.options, c.options.estimate);
                                                            }}),
                         [](const auto& each) { return std::string(each.param.name); });

}  // namespace
}  // namespace piste::test
