// Where a run begins: the heading found from every quadrant, at rest first and on the move, and what is said where it
// cannot be found. Seeds are 1, 2, 3 and so on.

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <ostream>

#include "piste/math/statistics.h"
#include "piste/math/units.h"
#include "start/start_place.h"
#include "support/simulated_case.h"
#include "support/text_file.h"
#include "support/thorough.h"

namespace piste::test {
namespace {

using Source = InitialHeading::Source;

/// Error of the heading at the start, and its sigma [deg].
struct HeadingError {
  double error, sigma;
};

HeadingError heading_error(const Case& c, const FoundStart& found) {
  const StateLayout layout(c.options.estimate);
  const Sigmas sigmas =
      sigmas_of(c.simulation.plate.world(), found.start.x, layout, initial_covariance(layout, c.options, found.start));
  // The world frames of simulation and log have their origins some metres apart: far below what matters here.
  const double truth = to_euler(c.simulation.bodies[0].at(found.start.time).q_wb).z();
  const double error = std::remainder(to_euler(found.start.x.q_wb).z() - truth, 360 * kDegree);
  return {error / kDegree, sigmas.euler.z() / kDegree};
}

/// A start claims some five times the sigma that was found, as the filter sees the same stretch again (start_place.h).
constexpr double kTempering = 25;

/// Headings found in many runs: errors within 4 of their sigmas, and these below `largest_sigma`, which is at most 1.6
/// times the largest of the usual seeds.
class Found {
 public:
  Found(std::string what, double largest_sigma) : what_(std::move(what)), largest_sigma_(largest_sigma) {}
  void add(const Case& c, const FoundStart& found) {
    const HeadingError h = heading_error(c, found);
    EXPECT_LT(std::abs(h.error), 4 * h.sigma) << what_ << ": " << found.how;
    EXPECT_LT(h.sigma, largest_sigma_) << what_;
    largest_ = std::max(largest_, h.sigma);
    nees_ += kTempering * h.error * h.error / (h.sigma * h.sigma);
    ++count_;
  }
  /// The mean NEES of what was found within the band of as many draws.
  void expect_true_sigmas() const {
    ASSERT_GT(count_, 0);
    const Band band = chi_squared_band(0.999, 1, count_);
    fmt::print("{:32} {:3} runs, largest sigma {:5.2f} deg, NEES {:.2f}, band {:.2f} to {:.2f}\n", what_, count_,
               largest_, nees_ / count_, band.low, band.high);
    EXPECT_LT(nees_ / count_, band.high) << what_ << ": " << nees_ / count_;
  }

 private:
  std::string what_;
  double largest_sigma_, largest_ = 0, nees_ = 0;
  int count_ = 0;
};

constexpr std::array kQuadrants{30, 120, 210, 300};

// Nothing tells the heading of a body that stands, and an unknown heading makes its tilt no surer. If the covariance is
// not carried over corrections, 12 deg become 8 in 20 s of rest, and the pitch is too sure by half.
TEST(Heading, StaysUnknownAtRest) {
  for (int seed = 1; seed <= seeds(4, 40); ++seed) {
    Case c = make_case("ski", 40 + 50 * seed, static_cast<std::uint64_t>(seed), [](Scenario& s) {
      s.motion.rest_before = 60;
      s.motion.run = 20;
    });
    c.options.estimate.push_back(Block::kLeverArm);
    c.options.priors.lever_arm = 0.3;
    const Log log = c.log();
    Start start = c.find().start;
    const auto after_rest = [&](double heading) {
      set_attitude_sigma(log.world, start, {2 * kDegree, 2 * kDegree, heading});
      const FilterRun run = run_filter(log, c.options, start, Keep::kNothing, {}, {.end = c.under_way() - 1});
      return run.solution.sigmas(run.solution.size() - 1).euler;
    };
    const Vector3d known = after_rest(0.1 * kDegree), unknown = after_rest(12 * kDegree);
    fmt::print("seed {}: pitch {:.3f} of {:.3f} deg, heading {:.2f} of 12 and {:.2f}\n", seed, unknown.y() / kDegree,
               known.y() / kDegree, unknown.z() / kDegree, known.z() / kDegree);
    EXPECT_NEAR(unknown.y(), known.y(), 0.03 * known.y()) << seed;
    EXPECT_NEAR(unknown.z(), std::hypot(12 * kDegree, known.z()), 0.02 * unknown.z()) << seed;
  }
}

/// Of `kQuadrants`, each with seeds of its own.
Found found_everywhere(const std::string& what, double largest_sigma,
                       const std::function<Case(int, std::uint64_t)>& make, const InitialHeading& heading = {}) {
  Found all(what, largest_sigma);
  std::uint64_t seed = 0;
  for (int n = 0; n < seeds(1, 8); ++n) {
    for (const int quadrant : kQuadrants) {
      const Case c = make(quadrant, ++seed);
      all.add(c, c.find(heading));
    }
  }
  return all;
}

struct FirstMotion {
  const char* name;
  double at_rest, moving;  ///< largest sigmas of the heading [deg]
};

void PrintTo(const FirstMotion& motion, std::ostream* out) { *out << motion.name; }

class Everywhere : public ::testing::TestWithParam<FirstMotion> {};

TEST_P(Everywhere, FoundFromRestAndOnTheMove) {
  constexpr std::array kLater{7.0, 18.3, 31.0};  // s under way
  const FirstMotion& motion = GetParam();
  Found at_rest(fmt::format("{} at rest", motion.name), motion.at_rest);
  std::vector<Found> moving;
  for (const double later : kLater) {
    moving.emplace_back(fmt::format("{} moving {} s", motion.name, later), motion.moving);
  }
  std::uint64_t seed = 0;
  for (int n = 0; n < seeds(1, 6); ++n) {
    for (const int heading : {30, 120, 179, 210, 300, 359}) {
      Case c = make_case(motion.name, heading, ++seed);
      at_rest.add(c, c.find());
      for (std::size_t i = 0; i < kLater.size(); ++i) {
        c.conditioning.span = {c.under_way() + kLater[i], c.under_way() + 60};
        moving[i].add(c, c.find());
      }
    }
  }
  at_rest.expect_true_sigmas();
  for (const Found& way : moving) way.expect_true_sigmas();
}

INSTANTIATE_TEST_SUITE_P(All, Everywhere,
                         ::testing::Values(FirstMotion{"ski", 4, 1.8}, FirstMotion{"giant_slalom", 3.6, 1.6},
                                           FirstMotion{"bicycle", 5.8, 4.5}),
                         [](const auto& each) { return std::string(each.param.name); });

TEST(Heading, WithPositionOnly) {
  found_everywhere("position only", 4.6, [](int heading, std::uint64_t seed) {
    Case c = make_case("giant_slalom", heading, seed);
    c.options.gnss[0].use_velocity = false;
    return c;
  }).expect_true_sigmas();
}

TEST(Heading, WithL1) {
  found_everywhere("L1", 6, [](int heading, std::uint64_t seed) {
    Case c = make_case("giant_slalom", heading, seed, [](Scenario& s) {
      s.gnss = read_scenario(s.file).gnss;
      s.gnss.erase(s.gnss.begin());
    });
    c.options.gnss[0].drift = c.scenario.gnss[0].position_drift;
    EXPECT_TRUE(c.options.gnss[0].drift);
    return c;
  }).expect_true_sigmas();
}

// Each hypothesis then takes a fix at a time of its own: one that is a fix ahead must not win by that.
TEST(Heading, WithADelayAndALeverArmToBeFound) {
  found_everywhere("delay and lever arm", 12, [](int heading, std::uint64_t seed) {
    Case c = make_case("easy_ski", heading, seed);
    c.options.estimate.insert(c.options.estimate.end(), {Block::kLeverArm, Block::kGnssDelay});
    c.options.gnss[0].lever_arm += Vector3d(0.1, -0.1, 0.1);
    c.options.priors.gnss_delay = 0.1;
    return c;
  }).expect_true_sigmas();
}

// A random walk starts from nothing: its prior is singular there.
TEST(Heading, WithDriftsThatWalk) {
  found_everywhere("random walk", 4.4, [](int heading, std::uint64_t seed) {
    Case c = make_case("giant_slalom", heading, seed);
    c.options.sensor.gyro.drift = {.kind = DriftProcess::Kind::kRandomWalk, .density = 1.7e-5};
    c.options.sensor.accel.drift = {.kind = DriftProcess::Kind::kRandomWalk, .density = 1e-3};
    return c;
  }).expect_true_sigmas();
}

// What is given is taken, with a sigma that a tilted start adds to.
TEST(Heading, FromAValue) {
  const Case c = make_case("ski", 210, 1);
  const double truth = to_euler(c.simulation.bodies[0].at(c.simulation.plate.start_time()).q_wb).z();
  const HeadingError h = heading_error(c, c.find({Source::kValue, truth + 3 * kDegree, 2 * kDegree}));
  EXPECT_NEAR(h.error, 3, 0.2);
  EXPECT_GT(h.sigma, 2);
  EXPECT_LT(h.sigma, 3);
}

// Sigmas of references and magnetometers are stated, and not of what was drawn: they are bounded, and not tested.
TEST(Heading, FromTheReferenceAttitude) {
  found_everywhere("attitude", 6,
                   [](int heading, std::uint64_t seed) {
                     Case c = make_case("ski", heading, seed,
                                        [](Scenario& s) { s.attitude = read_scenario(s.file).attitude; });
                     c.options.estimate.push_back(Block::kBoresight);
                     return c;
                   },
                   {.source = Source::kAttitude});
}

TEST(Heading, FromTheMagnetometer) {
  constexpr double kDeclination = 3 * kDegree;
  found_everywhere("magnetometer", 6,
                   [&](int heading, std::uint64_t seed) {
                     Case c = make_case("ski", heading, seed, [&](Scenario& s) {
                       s.imus[0].magnetic_field =
                           Vector3d(22 * std::cos(kDeclination), 22 * std::sin(kDeclination), 42);
                       s.imus[0].magnetometer.sigma = 0.3;
                     });
                     return c;
                   },
                   {.source = Source::kMagnetometer, .sigma = 3 * kDegree});
}

TEST(Heading, NothingMoves) {
  Case c = make_case("ski", 30, 1, [](Scenario& s) { s.motion.rest_before = 60; });
  c.conditioning.span = {0, c.under_way() - 2};
  const std::string message = message_of<DataError>([&] { c.find(); });
  EXPECT_TRUE(contains(message, "heading cannot be found"));
  EXPECT_TRUE(contains(message, "initial: {heading:"));
  EXPECT_NEAR(heading_error(c, c.find({Source::kValue, 30 * kDegree, 5 * kDegree})).sigma, 5.4, 0.6);
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
