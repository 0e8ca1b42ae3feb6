// Receivers whose error has a slow part, with no hands: `inspect` on their logs, which state the total, then a replay
// of what it wrote. Innovations show the white part alone.

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <functional>
#include <ostream>
#include <string>

#include "piste/diagnosis/diagnose.h"
#include "piste/experiment/inspect.h"
#include "piste/experiment/replay.h"
#include "piste/outputs/folders.h"
#include "support/simulated_case.h"
#include "support/text_file.h"
#include "support/thorough.h"

namespace piste::test {
namespace {

struct SlowReceiver {
  std::string name;
  double rate;
  Vector3d white;
  GaussMarkov slow;
  double velocity;  // m/s; 0: none
};

void PrintTo(const SlowReceiver& s, std::ostream* out) { *out << s.name; }

// Errors of positions in their sigmas.
struct Errors {
  double squares = 0, count = 0, inside = 0;

  void add(const Solution& solution, const Case& c) {
    const Truth& body = c.simulation.bodies.front();
    const Interval run = c.simulation.plate.under_way();
    double next = run.start + 5;
    for (std::size_t i = 0; i < solution.size() && solution.time(i) < run.end; ++i) {
      if (solution.time(i) < next) continue;
      next += 1;
      const Vector3d truth = solution.world().from_geodetic(body.world().to_geodetic(body.at(solution.time(i)).p_wb));
      const Vector3d error = solution.world().rotation_wn(truth).transpose() * (solution.estimate(i).p_wb - truth);
      for (const double e : error.cwiseQuotient(solution.sigmas(i).position)) {
        squares += e * e;
        inside += std::abs(e) < 3;
        ++count;
      }
    }
  }
  double mean_square() const { return squares / count; }
  double within() const { return inside / count; }
};

class SlowReceivers : public ::testing::TestWithParam<SlowReceiver> {};

TEST_P(SlowReceivers, SigmasHoldWithNoHands) {
  const SlowReceiver& receiver = GetParam();
  const int runs = seeds(2, 40);
  Errors filtered, smoothed;
  int too_large = 0;
  for (int run = 1; run <= runs; ++run) {
    const Case c = make_case("ski", 40, static_cast<std::uint64_t>(700 + run), [&](Scenario& s) {
      s.imus[0].clock_offset = s.imus[0].clock_drift = 0;
      s.gnss[0].rate = receiver.rate;
      s.gnss[0].position_noise = receiver.white;
      s.gnss[0].position_drift = receiver.slow;
      s.gnss[0].velocity_noise = Vector3d::Constant(receiver.velocity);
      s.motion.run = 150;
    });
    const TemporaryFolder folder;
    Inspection found = inspect({folder.write("imu.csv", imu_csv(c.simulation.imus[0].recording)),
                                folder.write("gnss.csv", gnss_csv(c.simulation.gnss[0]))});
    OutputFolder output(folder / "found");
    write_inspection(output, found);
    output.commit();
    const ReplayConfig config = read_replay_config(folder / "found/replay.yaml");
    ASSERT_EQ(config.filter.gnss.size(), 1U);
    EXPECT_GE(config.gnss[0].sigma_scales.position, 0.999) << run;
    const Replay replayed = replay(config);
    filtered.add(replayed.filtered.solution, c);
    smoothed.add(*replayed.smoothed, c);
    const Verdict verdict = diagnose(replayed.log, replayed.options, config.initial, replayed.found,
                                     replayed.filtered.solution, &*replayed.smoothed);
    too_large += verdict_line(verdict).find("too large") != std::string::npos ? 1 : 0;
  }
  fmt::print("{}, {} runs: filtered {:.3f} inside 3 sigma, mean square {:.2f}; smoothed {:.3f}, {:.2f}\n",
             receiver.name, runs, filtered.within(), filtered.mean_square(), smoothed.within(), smoothed.mean_square());
  EXPECT_EQ(too_large, 0);
  for (const Errors& e : {filtered, smoothed}) {
    EXPECT_GE(e.within(), 0.97);
    EXPECT_GT(e.mean_square(), 0.3);
    EXPECT_LT(e.mean_square(), 1.5);
  }
}

INSTANTIATE_TEST_SUITE_P(SlowReceiver, SlowReceivers,
                         ::testing::Values(SlowReceiver{"L1", 4, {0.4, 0.4, 0.4}, {{0.4, 0.4, 0.4}, 60}, 0.1},
                                           SlowReceiver{
                                               "Rtk", 10, {0.005, 0.005, 0.005}, {{0.01, 0.01, 0.01}, 60}, 0.025}),
                         [](const auto& all) { return all.param.name; });

}  // namespace
}  // namespace piste::test
