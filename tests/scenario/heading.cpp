// Where a run begins: the heading found from every quadrant, at rest first and on the move, and what is said where it
// cannot be found.

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "piste/math/units.h"
#include "support/simulated_case.h"
#include "support/text_file.h"

namespace piste::test {
namespace {

using Source = InitialHeading::Source;

/// Error of the heading at the start, and its sigma [deg].
struct HeadingError {
  double error, sigma;
};

HeadingError heading_error(const Case& c, const FoundStart& found) {
  const StateLayout layout(c.options.estimate);
  const Sigmas sigmas = sigmas_of(found.start.x, layout, initial_covariance(layout, c.options, found.start));
  // The world frames of simulation and log have their origins some metres apart: far below what matters here.
  const double truth = to_euler(c.simulation.bodies[0].at(found.start.time).q_wb).z();
  const double error = std::remainder(to_euler(found.start.x.q_wb).z() - truth, 360 * kDegree);
  return {error / kDegree, sigmas.euler.z() / kDegree};
}

void expect_found(const Case& c, const FoundStart& found, double largest_sigma, const std::string& what) {
  const HeadingError h = heading_error(c, found);
  EXPECT_LT(std::abs(h.error), 3 * h.sigma) << what << ": " << found.how;
  EXPECT_LT(h.sigma, largest_sigma) << what;
  std::printf("%-28s heading error %7.2f deg, sigma %5.2f deg\n", what.c_str(), h.error, h.sigma);
}

class Quadrant : public ::testing::TestWithParam<std::tuple<const char*, int>> {};

TEST_P(Quadrant, FoundFromRestAndOnTheMove) {
  const auto [motion, heading] = GetParam();
  Case c = make_case(motion, heading, static_cast<std::uint64_t>(heading));
  expect_found(c, c.find(), 15, fmt::format("{} {} at rest", motion, heading));
  for (const double later : {7.0, 18.3, 31.0}) {
    c.conditioning.span = {c.under_way() + later, c.under_way() + 60};
    expect_found(c, c.find(), 15, fmt::format("{} {} moving {}", motion, heading, later));
  }
}

INSTANTIATE_TEST_SUITE_P(All, Quadrant,
                         ::testing::Combine(::testing::Values("ski", "giant_slalom", "bicycle"),
                                            ::testing::Values(30, 120, 179, 210, 300, 359)),
                         [](const auto& each) {
                           return fmt::format("{}_{}", std::get<0>(each.param), std::get<1>(each.param));
                         });

TEST(Heading, WithPositionOnly) {
  for (const int heading : {30, 120, 210, 300}) {
    Case c = make_case("giant_slalom", heading, 5);
    c.options.gnss[0].use_velocity = false;
    expect_found(c, c.find(), 15, fmt::format("position only {}", heading));
  }
}

TEST(Heading, WithL1) {
  for (const int heading : {30, 120, 210, 300}) {
    Case c = make_case("giant_slalom", heading, 6, [](Scenario& s) {
      s.gnss = read_scenario(s.file).gnss;
      s.gnss.erase(s.gnss.begin());
    });
    c.options.gnss[0].drift = c.scenario.gnss[0].position_drift;
    ASSERT_TRUE(c.options.gnss[0].drift);
    expect_found(c, c.find(), 15, fmt::format("L1 {}", heading));
  }
}

// A random walk starts from nothing: its prior is singular there.
TEST(Heading, WithDriftsThatWalk) {
  for (const int heading : {30, 210}) {
    Case c = make_case("giant_slalom", heading, 5);
    c.options.sensor.gyro.drift = {.kind = DriftProcess::Kind::kRandomWalk, .density = 1.7e-5};
    c.options.sensor.accel.drift = {.kind = DriftProcess::Kind::kRandomWalk, .density = 1e-3};
    expect_found(c, c.find(), 15, fmt::format("random walk {}", heading));
  }
}

TEST(Heading, FromAValue) {
  const Case c = make_case("ski", 210, 3);
  const double truth = to_euler(c.simulation.bodies[0].at(c.simulation.plate.start_time()).q_wb).z();
  expect_found(c, c.find({Source::kValue, truth + 3 * kDegree, 2 * kDegree}), 4, "value");
}

TEST(Heading, FromTheReferenceAttitude) {
  for (const int heading : {30, 120, 210, 300}) {
    Case c = make_case("ski", heading, 3, [](Scenario& s) { s.attitude = read_scenario(s.file).attitude; });
    c.options.estimate.push_back(Block::kBoresight);
    expect_found(c, c.find({.source = Source::kAttitude}), 10, fmt::format("attitude {}", heading));
  }
}

TEST(Heading, FromTheMagnetometer) {
  constexpr double kDeclination = 3 * kDegree;
  for (const int heading : {30, 120, 210, 300}) {
    Case c = make_case("ski", heading, 3, [](Scenario& s) {
      s.imus[0].magnetic_field = Vector3d(22 * std::cos(kDeclination), 22 * std::sin(kDeclination), 42);
      s.imus[0].magnetic_noise = 0.3;
    });
    c.options.declination = kDeclination;
    expect_found(c, c.find({.source = Source::kMagnetometer, .sigma = 3 * kDegree}), 12,
                 fmt::format("magnetometer {}", heading));
  }
}

TEST(Heading, NothingMoves) {
  Case c = make_case("ski", 30, 1, [](Scenario& s) { s.motion.rest_before = 60; });
  c.conditioning.span = {0, c.under_way() - 2};
  const std::string message = message_of<DataError>([&] { c.find(); });
  EXPECT_TRUE(contains(message, "heading cannot be found"));
  EXPECT_TRUE(contains(message, "initial: {heading:"));
  expect_found(c, c.find({Source::kValue, 30 * kDegree, 5 * kDegree}), 6, "value at rest");
}

TEST(Heading, NoGnssWhileMoving) {
  Case c = make_case("ski", 30, 1);
  c.conditioning.outages = {{c.under_way() - 1, c.under_way() + 200}};
  EXPECT_TRUE(contains(message_of<DataError>([&] { c.find(); }), "while GNSS is there"));
}

TEST(Heading, NoGnss) {
  Case c = make_case("ski", 30, 1);
  Recording recording = c.simulation.recording(0);
  recording.gnss.clear();
  EXPECT_TRUE(contains(message_of<DataError>([&] { condition(recording, c.conditioning); }), "no GNSS"));
}

TEST(Heading, NoOverlap) {
  Case c = make_case("ski", 30, 1);
  c.conditioning.imu.clock_offset += 1000;
  EXPECT_TRUE(contains(message_of<DataError>([&] { c.find(); }), "no time in common"));
}

TEST(Heading, NoMagnetometer) {
  const Case c = make_case("ski", 30, 1);
  EXPECT_TRUE(contains(message_of<DataError>([&] { c.find({.source = Source::kMagnetometer}); }), "magnet"));
}

}  // namespace
}  // namespace piste::test
