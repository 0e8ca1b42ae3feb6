// An antenna on a helmet that moves on the body: sigmas hold with the key `lever_arm_sway`, and the verdict names it
// where it is not stated.

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>

#include "piste/diagnosis/diagnose.h"
#include "piste/outputs/folders.h"
#include "piste/replay/replay.h"
#include "piste/search/inspect.h"
#include "piste/sim/random.h"
#include "support/simulated_case.h"
#include "support/text_file.h"
#include "support/thorough.h"

namespace piste::test {
namespace {

// A sway of so many metres at 0.5 to 2 Hz along each axis of the body, as a sum of four tones.
class Sway {
 public:
  Sway(double amplitude, std::uint64_t seed) : amplitude_(amplitude / 2) {
    RandomStream random(seed, "sway");
    for (int axis = 0; axis < 3; ++axis) {
      for (int k = 0; k < 4; ++k) {
        frequency_[axis][k] = 2 * std::numbers::pi * (0.5 + 1.5 * random.uniform());
        phase_[axis][k] = 2 * std::numbers::pi * random.uniform();
      }
    }
  }
  Vector3d place(double t) const {
    return sum(t, [](double p, double) { return std::sin(p); });
  }
  Vector3d speed(double t) const {
    return sum(t, [](double p, double w) { return w * std::cos(p); });
  }

 private:
  template <class F>
  Vector3d sum(double t, F&& f) const {
    Vector3d s = Vector3d::Zero();
    for (int axis = 0; axis < 3; ++axis) {
      for (int k = 0; k < 4; ++k)
        s(axis) += amplitude_ * f(frequency_[axis][k] * t + phase_[axis][k], frequency_[axis][k]);
    }
    return s;
  }

  double amplitude_;
  double frequency_[3][4], phase_[3][4];
};

// A run of an L1/L2 receiver whose antenna sways while the body is under way.
Recording swaying(const Case& c, double amplitude, std::uint64_t seed) {
  const Sway sway(amplitude, seed);
  Recording recording = c.simulation.recording(0);
  const Truth& body = c.simulation.bodies.front();
  for (GeodeticFix& fix : recording.gnss[0].fixes) {
    if (!c.simulation.plate.under_way().contains(fix.time)) continue;
    const TruthState state = body.at(fix.time);
    const Vector3d s = sway.place(fix.time), moved = body.world().from_geodetic(fix.position) + state.q_wb * s;
    const Vector3d speed = state.q_wb * (sway.speed(fix.time) + state.w_ib_b.cross(s));
    fix.position = body.world().to_geodetic(moved);
    if (fix.velocity) fix.velocity->value += body.world().rotation_wn(moved).transpose() * speed;
  }
  return recording;
}

Case run_of(std::uint64_t seed) {
  return make_case("ski", 40, seed, [](Scenario& s) {
    s.gnss[0].position_noise = {0.015, 0.015, 0.03};
    s.gnss[0].position_drift.reset();
    s.motion.run = 90;
  });
}

// Mean square of errors over sigmas of position and velocity, under way.
struct Squares {
  double position = 0, velocity = 0, count = 0;

  void add(const Solution& solution, const Case& c) {
    const Truth& body = c.simulation.bodies.front();
    const Interval run = c.simulation.plate.under_way();
    double next = run.start + 5;
    for (std::size_t i = 0; i < solution.size() && solution.time(i) < run.end; ++i) {
      if (solution.time(i) < next) continue;
      next += 0.5;
      const TruthState state = body.at(solution.time(i));
      const World& world = solution.world();
      const Vector3d truth = world.from_geodetic(body.world().to_geodetic(state.p_wb));
      const Matrix3d R_nw = world.rotation_wn(truth).transpose();
      const Vector3d speed = R_nw.transpose() * (body.world().rotation_wn(state.p_wb).transpose() * state.v_wb);
      const Sigmas sigmas = solution.sigmas(i);
      const Vector3d p = R_nw * (solution.estimate(i).p_wb - truth), v = R_nw * (solution.estimate(i).v_wb - speed);
      position += p.cwiseQuotient(sigmas.position).squaredNorm() / 3;
      velocity += v.cwiseQuotient(sigmas.velocity).squaredNorm() / 3;
      ++count;
    }
  }
};

TEST(SwayingAntenna, SigmasHoldWithTheKey) {
  Squares filtered, smoothed, without;
  for (int k = 1; k <= seeds(3, 20); ++k) {
    Case c = run_of(static_cast<std::uint64_t>(40 + k));
    const Recording recording = swaying(c, 0.04, static_cast<std::uint64_t>(k));
    const auto run = [&] { return replay(recording, {.conditioning = c.conditioning, .filter = c.options}); };
    without.add(run().filtered.solution, c);
    c.options.gnss[0].lever_arm_sway = GaussMarkov{Vector3d::Constant(0.028), 0.1};
    c.options.estimate = with_implied_blocks(c.options, c.options.estimate);
    const Replay replayed = run();
    filtered.add(replayed.filtered.solution, c);
    smoothed.add(*replayed.smoothed, c);
  }
  fmt::print(
      "mean square of position and velocity: filtered {:.2f} {:.2f}, smoothed {:.2f} {:.2f}; without {:.2f} {:.2f}\n",
      filtered.position / filtered.count, filtered.velocity / filtered.count, smoothed.position / smoothed.count,
      smoothed.velocity / smoothed.count, without.position / without.count, without.velocity / without.count);
  EXPECT_GT(without.position / without.count, 2) << "it matters";
  for (const Squares& s : {filtered, smoothed}) {
    for (const double square : {s.position / s.count, s.velocity / s.count}) {
      EXPECT_GT(square, 0.3);
      EXPECT_LT(square, 1.5);
    }
  }
}

TEST(SwayingAntenna, IsNamedWhereItIsNotStated) {
  for (int k = 1; k <= seeds(2, 20); ++k) {
    Case c = run_of(static_cast<std::uint64_t>(60 + k));
    const ReplayOptions options{.conditioning = c.conditioning, .filter = c.options};
    const Replay run = replay(swaying(c, 0.04, static_cast<std::uint64_t>(100 + k)), options);
    const Verdict v = diagnose(run.log, run.options, options.heading, run.found, run.filtered.solution, &*run.smoothed);
    EXPECT_FALSE(v.consistent);
    ASSERT_FALSE(v.findings.empty());
    EXPECT_TRUE(v.findings.front().starts_with("antenna of gnss[0]")) << fmt::format("{}", fmt::join(v.findings, "\n"));
  }
}

// Larger sigmas hide the sway from the verdict, and not from `inspect`.
TEST(SwayingAntenna, IsNamedByInspect) {
  for (int k = 0; k < seeds(2, 10); ++k) {
    const auto seed = static_cast<std::uint64_t>(81 + k / 2);
    const double amplitude = k % 2 == 0 ? 0 : 0.04;
    const Case c = run_of(seed);
    const Recording recording = swaying(c, amplitude, seed);
    const TemporaryFolder folder;
    Inspection found = inspect(
        {folder.write("imu.csv", imu_csv(recording.imu)), folder.write("gnss.csv", gnss_csv(recording.gnss[0]))});
    OutputFolder output(folder / "found");
    write_inspection(output, found);
    const bool named =
        std::ranges::any_of(found.suspicions, [](const Suspicion& s) { return s.fault == LogFault::kAntennaSways; });
    std::string all;
    for (const InspectedRound& round : found.rounds) all += round.verdict + ", then taken: " + round.taken + '\n';
    for (const Suspicion& s : found.suspicions) all += s.what + '\n';
    EXPECT_EQ(named, amplitude > 0) << all;
  }
}

}  // namespace
}  // namespace piste::test
