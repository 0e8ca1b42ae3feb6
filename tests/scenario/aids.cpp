// Magnetometer, barometer and two antennas, each as the only help: what GNSS and motion do not tell, they do, within
// their sigmas, and what they add to the truth is found.

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>
#include <optional>

#include "piste/math/statistics.h"
#include "piste/replay/replay.h"
#include "piste/sim/replay_setup.h"
#include "support/simulated_case.h"
#include "support/thorough.h"

namespace piste::test {
namespace {

// The bicycle lap of bicycle_aids.yaml with one of its sensors: `keep` says which.
Case lap(std::uint64_t seed, const std::function<void(Scenario&)>& keep) {
  Case c = make_case("montecarlo/bicycle_aids", 10 + 97 * static_cast<double>(seed), seed, [&](Scenario& s) {
    s.motion.run = 150;
    keep(s);
  });
  set_aids(c.options, c.scenario, c.scenario.imus[0]);
  c.options.estimate = with_implied_blocks(c.options, c.options.estimate);
  c.conditioning.magnetic = {.year = 2026, .interval = kMagneticInterval};  // the model's field, by the place
  return c;
}

// Far from steel: 1 µT of it, as the scenario has, would be 2.7 deg of heading at any instant.
void magnetometer_alone(Scenario& s) {
  s.aids = {};
  s.imus[0].magnetometer.disturbance.sigma = Vector3d::Constant(0.2);
}
// In settled weather: that of the scenario changes the height by 5 m a minute.
void barometer_alone(Scenario& s) {
  s.aids.barometer->errors.offset = {{30, 0, 0}, 360000};
  s.aids.heading.reset();
  s.imus[0].magnetic_field.reset();
}
void antennas_alone(Scenario& s) {
  s.aids.barometer.reset();
  s.imus[0].magnetic_field.reset();
}

Replay filtered(const Case& c, bool helped, const InitialHeading& heading = {}) {
  ReplayOptions options{.conditioning = {}, .filter = c.options, .heading = heading, .smoother = SmootherKind::kNone};
  Log log = c.log();
  if (!helped) {
    log.magnetic.clear();
    log.height.clear();
    log.heading.clear();
    for (const Block block : {Block::kHardIron, Block::kSoftIronX, Block::kSoftIronY, Block::kSoftIronZ,
                              Block::kMagneticDisturbance, Block::kBarometerOffset}) {
      std::erase(options.filter.estimate, block);
    }
    options.filter.magnetometer.reset();
    options.filter.barometer.reset();
    options.filter.heading.reset();
  }
  return replay(std::move(log), options);
}

struct Error {
  double heading = 0, height = 0, heading_sigma = 0, height_sigma = 0;
};

// Of the last row before `time`.
Error error_at(const Case& c, const Replay& run, double time) {
  const Solution& s = run.filtered.solution;
  std::size_t i = s.size() - 1;
  while (i > 0 && s.time(i) > time) --i;
  const Truth& body = c.simulation.bodies[0];
  const TruthState truth = body.at(s.time(i));
  const Estimate x = s.estimate(i);
  const Geodetic there = body.world().to_geodetic(truth.p_wb);
  const auto level = [](const World& world, const Vector3d& p, const Quaterniond& q) {
    return to_euler(Quaterniond(world.rotation_wn(p)).conjugate() * q);
  };
  const double heading = level(s.world(), x.p_wb, x.q_wb).z() - level(body.world(), truth.p_wb, truth.q_wb).z();
  const Sigmas sigmas = s.sigmas(i);
  return {std::remainder(heading, 2 * std::numbers::pi), s.world().to_geodetic(x.p_wb).height - there.height,
          sigmas.euler.z(), sigmas.position.z()};
}

// Mean squares of errors, plain and over their sigmas.
struct Squares {
  double plain = 0, normalised = 0;
  int count = 0;

  void add(double error, double sigma) {
    plain += error * error;
    normalised += error * error / (sigma * sigma);
    ++count;
  }
  double rms() const { return std::sqrt(plain / count); }
  double nees() const { return normalised / count; }
  void expect_true_sigmas(const char* what) const {
    const Band band = chi_squared_band(0.999, 1, count);
    EXPECT_LT(nees(), band.high) << what;
    EXPECT_GT(nees(), band.low) << what;
  }
};

// Without GNSS for 90 s, the field of the Earth holds the heading, through iron that nobody has calibrated: it was
// found before, to a fraction of the 10 µT and 3 % that it is drawn with.
TEST(Aids, TheMagnetometerHoldsTheHeadingAndFindsItsIron) {
  Squares with, without, hard, soft;
  for (int seed = 1; seed <= seeds(4, 30); ++seed) {
    Case c = lap(static_cast<std::uint64_t>(seed), magnetometer_alone);
    ASSERT_TRUE(c.scenario.imus[0].magnetic_field);
    const Interval outage{c.under_way() + 55, c.under_way() + 145};
    c.conditioning.outages = {outage};
    const Replay helped = filtered(c, true);
    const Error e = error_at(c, helped, outage.end), free = error_at(c, filtered(c, false), outage.end);
    with.add(e.heading, e.heading_sigma);
    without.add(free.heading, free.heading_sigma);
    const Solution& s = helped.filtered.solution;
    const Estimate x = s.estimate(s.size() - 1);
    const Sigmas sigmas = s.sigmas(s.size() - 1);
    const SimulatedImu& truth = c.simulation.imus[0];
    for (int k = 0; k < 3; ++k) {
      hard.add(x.hard_iron(k) - truth.hard_iron(k), sigmas.blocks(full_offset(Block::kHardIron) + k));
      soft.add(x.soft_iron_x(k) - truth.soft_iron(0, k), sigmas.blocks(full_offset(Block::kSoftIronX) + k));
    }
  }
  fmt::print(
      "heading after 90 s without GNSS: {:.2f} deg rms, {:.2f} without magnetometer; hard iron {:.2f} uT, soft "
      "iron {:.4f}; NEES {:.2f}, {:.2f}, {:.2f}\n",
      with.rms() / kDegree, without.rms() / kDegree, hard.rms(), soft.rms(), with.nees(), hard.nees(), soft.nees());
  EXPECT_LT(with.rms(), 2 * kDegree);
  EXPECT_LT(with.rms(), 0.7 * without.rms());
  EXPECT_LT(hard.rms(), 2);
  with.expect_true_sigmas("heading");
  hard.expect_true_sigmas("hard iron");
  soft.expect_true_sigmas("soft iron");
}

// Without GNSS for a minute the air holds the height, although its pressure is that of an unknown day.
TEST(Aids, TheBarometerHoldsTheHeight) {
  Squares with, without;
  for (int seed = 1; seed <= seeds(4, 30); ++seed) {
    Case c = lap(static_cast<std::uint64_t>(seed), barometer_alone);
    const Interval outage{c.under_way() + 60, c.under_way() + 120};
    c.conditioning.outages = {outage};
    const Error e = error_at(c, filtered(c, true), outage.end), free = error_at(c, filtered(c, false), outage.end);
    with.add(e.height, e.height_sigma);
    without.add(free.height, free.height_sigma);
  }
  fmt::print("height after 60 s without GNSS: {:.2f} m rms, {:.1f} without barometer; NEES {:.2f}\n", with.rms(),
             without.rms(), with.nees());
  EXPECT_LT(with.rms(), 2);
  EXPECT_LT(with.rms(), 0.2 * without.rms());
  with.expect_true_sigmas("height");
}

// Before anything moves, two antennas tell the heading, of which no more than a guess is known.
TEST(Aids, TwoAntennasTellTheHeadingAtRest) {
  Squares with, without;
  for (int seed = 1; seed <= seeds(6, 40); ++seed) {
    Case c = lap(static_cast<std::uint64_t>(seed), antennas_alone);
    const double departure = c.under_way();
    c.conditioning.span = {0, departure};
    const double truth = to_euler(c.simulation.bodies[0].at(departure - 1).q_wb).z();
    const InitialHeading guess{InitialHeading::Source::kValue, truth + (seed % 2 == 0 ? 15 : -15) * kDegree,
                               15 * kDegree};
    const Error e = error_at(c, filtered(c, true, guess), departure - 1);
    const Error alone = error_at(c, filtered(c, false, guess), departure - 1);
    without.add(alone.heading, alone.heading_sigma);
    with.add(e.heading, e.heading_sigma);
  }
  fmt::print("heading at rest: {:.3f} deg rms, {:.1f} without antennas; NEES {:.2f}\n", with.rms() / kDegree,
             without.rms() / kDegree, with.nees());
  EXPECT_GT(without.rms(), 5 * kDegree) << "nothing else tells it well";
  EXPECT_LT(with.rms(), 0.3 * kDegree);
  with.expect_true_sigmas("heading");
}

// The largest error of a run from `from` on, in its sigmas: of the heading, the height, and north and east.
double worst_in_sigmas(const Case& c, const Replay& run, double from) {
  const Solution& s = run.filtered.solution;
  const Truth& body = c.simulation.bodies[0];
  double worst = 0;
  for (std::size_t i = 0; i < s.size(); i += 50) {
    if (s.time(i) < from) continue;
    const Error e = error_at(c, run, s.time(i));
    worst = std::max({worst, std::abs(e.heading) / e.heading_sigma, std::abs(e.height) / e.height_sigma});
    const Vector3d is = s.world().from_geodetic(body.world().to_geodetic(body.at(s.time(i)).p_wb));
    const Vector3d off = s.estimate(i).p_wb - is;
    worst = std::max(worst, (off.cwiseQuotient(s.sigmas(i).position)).head<2>().cwiseAbs().maxCoeff());
  }
  return worst;
}

// A wrong ambiguity turns the baseline for ten seconds: the filter, whose heading the motion tells, does not follow.
TEST(Aids, AHeadingThatJumpsTurnsNobody) {
  for (const double jump : {20 * kDegree, std::numbers::pi}) {
    const Case c = lap(1, antennas_alone);
    const Interval wrong{c.under_way() + 60, c.under_way() + 70};
    Log log = c.log();
    for (HeadingFix& fix : log.heading) {
      if (wrong.contains(fix.time)) fix.heading += jump;
    }
    const Replay run = replay(
        std::move(log), {.conditioning = {}, .filter = c.options, .heading = {}, .smoother = SmootherKind::kNone});
    EXPECT_LT(worst_in_sigmas(c, run, c.under_way() + 20), 6) << jump / kDegree;
  }
}

// A door lets the pressure jump for ten seconds, or a vent opens and stays open: the height is not in doubt.
TEST(Aids, APressureThatJumpsLiftsNobody) {
  for (const double length : {10.0, 1000.0}) {
    const Case c = lap(1, barometer_alone);
    const Interval wrong{c.under_way() + 60, c.under_way() + 60 + length};
    Log log = c.log();
    for (HeightFix& fix : log.height) {
      if (wrong.contains(fix.time)) fix.height += 4;
    }
    const Replay run = replay(
        std::move(log), {.conditioning = {}, .filter = c.options, .heading = {}, .smoother = SmootherKind::kNone});
    EXPECT_LT(worst_in_sigmas(c, run, c.under_way() + 20), 6) << length;
  }
}

}  // namespace
}  // namespace piste::test
