// The batch where fixes are wrong, and where nothing is known of the heading: against the truth of simulated ski runs.

#include "piste/batch/batch.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "piste/math/units.h"
#include "piste/replay/replay.h"
#include "piste/sim/random.h"
#include "support/simulated_case.h"
#include "support/thorough.h"

namespace piste::test {
namespace {

Replay solved_by(SmootherKind smoother, const Case& c, const Log& log) {
  ReplayOptions options{.conditioning = {}, .filter = c.options, .heading = {}};
  options.smoother = smoother;
  options.batch = batch_solver();
  return replay(log, options);
}

// Root mean square and largest error of the smoothed position [m].
struct PositionError {
  double rms = 0, largest = 0;
};

PositionError error_of(const Case& c, const Solution& s, const Interval& during) {
  const Truth& truth = c.simulation.bodies[0];
  PositionError out;
  double squares = 0;
  int count = 0;
  for (std::size_t i = 0; i < s.size(); ++i) {
    if (!during.contains(s.time(i))) continue;
    const Vector3d is = s.world().from_geodetic(truth.world().to_geodetic(truth.at(s.time(i)).p_wb));
    const double error = (s.estimate(i).p_wb - is).norm();
    squares += error * error;
    out.largest = std::max(out.largest, error);
    ++count;
  }
  out.rms = std::sqrt(squares / count);
  return out;
}

// A fifth of the positions, and with them of what the receiver claims to know to a metre, is 2 to 100 m off.
TEST(BatchRobust, AFifthOfWrongPositionsCostsLittle) {
  double clean = 0, spoiled = 0, squared = 0;
  const int runs = seeds(3, 20);
  for (int seed = 1; seed <= runs; ++seed) {
    const Case c = make_case("ski", 70 * seed, static_cast<std::uint64_t>(seed));
    Log log = c.log();
    const Interval all{c.under_way() - 10, c.under_way() + 62};
    clean += std::pow(error_of(c, *solved_by(SmootherKind::kBatch, c, log).smoothed, all).rms, 2);
    RandomStream random(static_cast<std::uint64_t>(seed), "wrong positions");
    for (GnssFix& fix : log.gnss[0]) {
      if (random.uniform() > 0.2) continue;
      fix.position += 2 * std::pow(50, random.uniform()) * random.normal3().normalized();
    }
    const Replay batch = solved_by(SmootherKind::kBatch, c, log);
    EXPECT_TRUE(batch.smoothed->batch->converged) << seed;
    spoiled += std::pow(error_of(c, *batch.smoothed, all).rms, 2);
    const auto all_count = run_batch(log, batch.options, batch.found, batch.filtered, {.loss = BatchLoss::kSquared});
    squared += std::pow(error_of(c, all_count->solution(), all).rms, 2);
  }
  const auto rms = [&](double sum) { return std::sqrt(sum / runs); };
  fmt::print("clean {:.5f} m, a fifth wrong {:.5f} m, what the filter used {:.3f} m\n", rms(clean), rms(spoiled),
             rms(squared));
  EXPECT_LT(rms(spoiled), 1.1 * rms(clean));
}

// A receiver that claims centimetres, and for half of a minute is a metre off with all of them.
TEST(BatchRobust, AWrongFixedMinuteIsLeftOut) {
  for (int seed = 1; seed <= seeds(2, 10); ++seed) {
    const Case c = make_case("ski", 50 * seed, static_cast<std::uint64_t>(seed), [](Scenario& s) {
      s.gnss[0].position_noise = {0.01, 0.01, 0.015};
      s.gnss[0].position_drift.reset();
    });
    Log log = c.log();
    const Interval wrong{c.under_way() + 20, c.under_way() + 50};
    for (GnssFix& fix : log.gnss[0]) {
      if (wrong.contains(fix.time)) fix.position += Vector3d(0.6, -0.7, 0.39).normalized();
    }
    const Replay rts = solved_by(SmootherKind::kRts, c, log), batch = solved_by(SmootherKind::kBatch, c, log);
    const PositionError of_rts = error_of(c, *rts.smoothed, wrong), of_batch = error_of(c, *batch.smoothed, wrong);
    fmt::print("filtered and smoothed {:.3f} m rms, {:.3f} m at most; batch {:.3f} m, {:.3f} m; {}\n", of_rts.rms,
               of_rts.largest, of_batch.rms, of_batch.largest, batch.smoothed->batch->left_out);
    EXPECT_LT(of_batch.rms, 0.1);
  }
}

// From any heading, without a rest.
TEST(BatchStart, ConvergesFromAnyHeading) {
  const int runs = seeds(8, 100);
  int converged = 0;
  for (int seed = 1; seed <= runs; ++seed) {
    const double heading = 360 * RandomStream(static_cast<std::uint64_t>(seed), "heading").uniform();
    const Case c = make_case("ski", heading, static_cast<std::uint64_t>(seed),
                             [](Scenario& s) { s.motion.rest_before = s.motion.rest_after = 0; });
    const Replay run = solved_by(SmootherKind::kBatch, c, c.log());
    const Solution& s = *run.smoothed;
    const std::size_t middle = s.size() / 2;
    const TruthState is = c.simulation.bodies[0].at(s.time(middle));
    const double off = so3_log(s.estimate(middle).q_wb * is.q_wb.conjugate()).norm();
    EXPECT_LT(off, 1.5 * kDegree) << seed;
    EXPECT_TRUE(s.batch->converged) << seed;
    if (s.batch->converged) ++converged;
  }
  EXPECT_EQ(converged, runs);
}

}  // namespace
}  // namespace piste::test
