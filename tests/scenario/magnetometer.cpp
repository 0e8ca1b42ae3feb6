// A magnetometer whose iron nobody has calibrated: motion under GNSS tells the iron, and the field then holds the
// heading while nothing else tells it. A girder beside the way is let go.

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "piste/experiment/replay.h"
#include "piste/math/magnetic_field.h"
#include "support/simulated_case.h"

namespace piste::test {
namespace {

// A ride, and after it a rest of some minutes, in which the heading of a gyroscope drifts off.
Case ride_with_field(std::uint64_t seed) {
  Case c = make_case("bicycle", 40, seed, [](Scenario& s) {
    s.motion.run = 90;
    s.motion.rest_after = 240;
    s.imus[0].magnetic_field = magnetic_field(s.origin, 2026);
    s.imus[0].magnetometer = {
        .sigma = 0.5, .hard_iron = 10, .soft_iron = 0.03, .disturbance = {Vector3d::Constant(0.5), 10}};
  });
  c.conditioning.magnetic.interval = kMagneticInterval;
  return c;
}

Replay replay_with_field(const Case& c, Log log, bool magnetometer) {
  ReplayOptions options{.conditioning = {}, .filter = c.options, .heading = {}};
  options.smoother = SmootherKind::kNone;
  if (magnetometer) options.filter.magnetometer = c.scenario.imus[0].magnetometer;
  options.filter.estimate = with_implied_blocks(options.filter, options.filter.estimate);
  return replay(std::move(log), options);
}

struct HeldHeading {
  double error = 0, sigma = 0;  // deg, at the end
};

HeldHeading last_heading(const Case& c, const Replay& run) {
  const Solution& s = run.filtered.solution;
  const std::size_t last = s.size() - 1;
  const double truth = to_euler(c.simulation.bodies[0].at(s.time(last)).q_wb).z();
  const double error = std::remainder(to_euler(s.estimate(last).q_wb).z() - truth, 360 * kDegree);
  return {error / kDegree, s.sigmas(last).euler.z() / kDegree};
}

TEST(Magnetometer, TellsItsIronAndHoldsTheHeading) {
  double with = 0, without = 0;
  for (const std::uint64_t seed : {1, 2, 3}) {
    const Case c = ride_with_field(seed);
    const Replay run = replay_with_field(c, c.log(), true), gyro = replay_with_field(c, c.log(), false);
    const Solution& s = run.filtered.solution;
    const Estimate x = s.estimate(s.size() - 1);
    const Vector3d iron = x.hard_iron - c.simulation.imus[0].hard_iron;
    const FullError sigma = s.sigmas(s.size() - 1).blocks;
    for (int k = 0; k < 3; ++k) EXPECT_LT(std::abs(iron(k)), 4 * sigma(full_offset(Block::kHardIron) + k));
    const HeldHeading held = last_heading(c, run), drifted = last_heading(c, gyro);
    fmt::print("iron {:.2f} of {:.2f} uT, heading {:.2f} ± {:.2f} deg, without {:.2f} ± {:.2f} deg\n", iron.norm(),
               c.simulation.imus[0].hard_iron.norm(), held.error, held.sigma, drifted.error, drifted.sigma);
    EXPECT_LT(std::abs(held.error), 4 * held.sigma);
    EXPECT_LT(held.sigma, 0.7 * drifted.sigma);
    with += held.error * held.error;
    without += drifted.error * drifted.error;
  }
  EXPECT_LT(with, without);
}

// 25 µT on one axis for 40 s of the rest: outside the gate, and the heading stays.
TEST(Magnetometer, ADisturbanceIsLetGo) {
  const Case c = ride_with_field(4);
  Log log = c.log();
  const double begin = c.simulation.plate.under_way().end + 100;
  std::size_t spoilt = 0;
  for (MagneticSample& sample : log.magnetic) {
    if (sample.time < begin || sample.time > begin + 40) continue;
    sample.field.y() += 25;
    ++spoilt;
  }
  const Replay run = replay_with_field(c, std::move(log), true);
  std::size_t refused = 0;
  for (const Innovation& i : run.filtered.solution.innovations) {
    if (run.filtered.solution.sources[static_cast<std::size_t>(i.source)] != "magnetometer") continue;
    if (i.time >= begin && i.time <= begin + 40 && !was_used(i.outcome)) ++refused;
  }
  const HeldHeading held = last_heading(c, run);
  fmt::print("refused {} of {}, heading {:.2f} ± {:.2f} deg\n", refused, spoilt, held.error, held.sigma);
  EXPECT_GT(refused, 0.95 * static_cast<double>(spoilt));
  EXPECT_LT(std::abs(held.error), 4 * held.sigma);
}

}  // namespace
}  // namespace piste::test
