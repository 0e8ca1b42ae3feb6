// Receivers whose error has a slow part, with no hands: `inspect` on their logs, which state the total, a replay of
// what it wrote, `tune` of that, and a replay again. Innovations show the white part alone.

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <ostream>
#include <string>

#include "piste/diagnosis/diagnose.h"
#include "piste/files/tuning.h"
#include "piste/model/gnss.h"
#include "piste/outputs/folders.h"
#include "piste/replay/replay.h"
#include "piste/search/inspect.h"
#include "piste/search/tune.h"
#include "support/random.h"
#include "support/simulated_case.h"
#include "support/text_file.h"
#include "support/thorough.h"

namespace piste::test {
namespace {

struct SlowReceiver {
  std::string name;
  double rate;
  double white;  // m
  GaussMarkov slow;
  double velocity;  // m/s; 0: none
  bool usual;       // whether it runs on each change

  std::string whole_name() const { return name + (velocity > 0 ? "" : "WithoutVelocities"); }
};

void PrintTo(const SlowReceiver& s, std::ostream* out) { *out << s.whole_name(); }

// Where the solution has the antenna at the time of a fix, in its own world frame: with the lever arm, the delay and
// the clock's drift that it estimates, else with what is stated.
Vector3d antenna_at(const Solution& solution, const FilterOptions& options, double t, std::size_t& after) {
  const GnssOptions& receiver = options.gnss[0];
  const auto fix_time = [&](std::size_t i) {  // of a fix that is of epoch i
    const double elapsed = solution.time(i) - solution.time(0);
    return solution.time(i) +
           GnssReceivers::delay(options, solution.layout(), 0, 0, solution.estimate(i), elapsed).value;
  };
  while (after + 1 < solution.size() && fix_time(after) < t) ++after;
  const std::size_t before = after == 0 ? 0 : after - 1;
  const double length = fix_time(after) - fix_time(before);
  const double part = length > 0 ? (t - fix_time(before)) / length : 0;
  const bool estimated = solution.layout().has(Block::kLeverArm);
  const auto antenna = [&](const Estimate& x) {
    return (x.p_wb + x.q_wb * (estimated ? x.lever_arm : receiver.lever_arm)).eval();
  };
  return (1 - part) * antenna(solution.estimate(before)) + part * antenna(solution.estimate(after));
}

// Errors of positions: in m, in their sigmas, and of the antenna where there are fixes.
struct Errors {
  double squares = 0, metres = 0, count = 0, inside = 0;
  double antenna = 0, fixes = 0;

  void add(const Solution& solution, const Case& c, const FilterOptions& options) {
    const Vector3d arm = lever_arm(c.scenario.imus[0], c.scenario.gnss[0]);
    const Truth& body = c.simulation.bodies.front();
    const Interval run = c.simulation.plate.under_way();
    const World& world = solution.world();
    double next = run.start + 5;
    for (std::size_t i = 0; i < solution.size() && solution.time(i) < run.end; ++i) {
      if (solution.time(i) < next) continue;
      next += 1;
      const Vector3d truth = world.from_geodetic(body.world().to_geodetic(body.at(solution.time(i)).p_wb));
      const Vector3d error = world.rotation_wn(truth).transpose() * (solution.estimate(i).p_wb - truth);
      metres += error.squaredNorm() / 3;
      const Vector3d by_sigma = error.cwiseQuotient(solution.sigmas(i).position);
      squares += by_sigma.squaredNorm() / 3;
      inside += static_cast<double>((by_sigma.array().abs() < 3).count()) / 3;
      ++count;
    }
    std::size_t after = 0;
    for (const GeodeticFix& fix : c.simulation.gnss[0].fixes) {
      if (!run.contains(fix.time) || fix.time < run.start + 5) continue;
      const TruthState state = body.at(fix.time);
      const Vector3d truth = world.from_geodetic(body.world().to_geodetic(state.p_wb + state.q_wb * arm));
      fixes += (world.from_geodetic(fix.position) - truth).squaredNorm();
      antenna += (antenna_at(solution, options, fix.time, after) - truth).squaredNorm();
    }
  }
  double mean_square() const { return squares / count; }
  double within() const { return inside / count; }
  double rmse() const { return std::sqrt(metres / count); }
  double of_fixes() const { return std::sqrt(antenna / fixes); }
};

struct Both {
  Errors filtered, smoothed;
};

// What inspect writes from the logs alone.
ReplayConfig inspected_config(const TemporaryFolder& folder, const Case& c) {
  Inspection found = inspect({folder.write("samples.csv", imu_csv(c.simulation.imus[0].recording)),
                              folder.write("rtk.csv", gnss_csv(c.simulation.gnss[0]))});
  OutputFolder output(folder / "found");
  write_inspection(output, found);
  output.commit();
  return read_replay_config(folder / "found/replay.yaml");
}

class SlowReceivers : public ::testing::TestWithParam<SlowReceiver> {
 protected:
  // Replays a configuration; whether its verdict says that sigmas are too large counts.
  void run(const ReplayConfig& config, const Case& c, Both& errors, bool judged = true) {
    const Replay replayed = replay(config);
    errors.filtered.add(replayed.filtered.solution, c, replayed.options);
    errors.smoothed.add(*replayed.smoothed, c, replayed.options);
    if (!judged) return;
    const Verdict verdict = diagnose(replayed.log, replayed.options, config.initial, replayed.found,
                                     replayed.filtered.solution, &*replayed.smoothed);
    const std::string line = verdict_line(verdict);
    EXPECT_EQ(line.find("too large"), std::string::npos) << line;
  }
};

// The same configuration with the receiver's true noise.
ReplayConfig with_true_noise(ReplayConfig config, const SlowReceiver& receiver) {
  config.gnss[0].sigma_scales = {.velocity = config.gnss[0].sigma_scales.velocity};
  config.filter.gnss[0].drift = receiver.slow;
  std::erase(config.filter.estimate, position_drift_block(0, true));
  config.filter.estimate = with_implied_blocks(config.filter, config.filter.estimate);
  return config;
}

void expect_true(const Errors& e, const std::string& what) {
  EXPECT_GE(e.within(), 0.97) << what;
  // A run of 150 s has two or three slow errors of a minute, so that a single one may be as right by chance.
  if (thorough()) {
    EXPECT_GT(e.mean_square(), 0.3) << what;
    EXPECT_LT(e.of_fixes(), 1) << what;
  }
  EXPECT_LT(e.mean_square(), 1.5) << what;
}

TEST_P(SlowReceivers, SigmasHoldWithNoHands) {
  const SlowReceiver& receiver = GetParam();
  if (!receiver.usual && !thorough()) GTEST_SKIP() << "PISTE_THOROUGH=1 runs it";
  const int runs = seeds(1, 40);
  Both inspected, tuned, told;
  for (int k = 1; k <= runs; ++k) {
    const Case c = make_case("ski", 40, static_cast<std::uint64_t>(700 + k), [&](Scenario& s) {
      s.imus[0].clock_offset = s.imus[0].clock_drift = 0;
      s.gnss[0].rate = receiver.rate;
      s.gnss[0].position_noise.setConstant(receiver.white);
      s.gnss[0].position_drift = receiver.slow;
      s.gnss[0].velocity_noise.setConstant(receiver.velocity);
      s.motion.run = 150;
    });
    const TemporaryFolder folder;
    const ReplayConfig config = inspected_config(folder, c);
    ASSERT_EQ(config.filter.gnss.size(), 1U);
    EXPECT_GE(config.gnss[0].sigma_scales.position, 0.999) << k;
    run(config, c, inspected);
    run(with_true_noise(config, receiver), c, told, false);

    TuneOptions how{.jobs = 1};
    how.stated.push_back(stated_before(config.gnss[0].sigma_scales));
    OutputFolder tuning(folder / "tuned");
    write_tuning(tuning, config, tune(read_recording(config), replay_options(config), how));
    tuning.commit();
    run(read_replay_config(folder / "tuned/replay.yaml"), c, tuned);
    fmt::print("{}: inspect {:.2f} {:.2f}, tune {:.2f} {:.2f}\n", k, inspected.filtered.mean_square(),
               inspected.smoothed.mean_square(), tuned.filtered.mean_square(), tuned.smoothed.mean_square());
  }
  const auto row = [&](const char* from, const Both& both) {
    for (const auto& [name, e, best] :
         {std::tuple("filtered", both.filtered, told.filtered), std::tuple("smoothed", both.smoothed, told.smoothed)}) {
      fmt::print("| {} | {} | {} | {:.1f} % | {:.2f} | {:.3f} m | {:.2f} | {:.2f} |\n", receiver.whole_name(), from,
                 name, 100 * e.within(), e.mean_square(), e.rmse(), e.rmse() / best.rmse(), e.of_fixes());
      if (thorough()) {
        EXPECT_LE(e.rmse(), 1.1 * best.rmse()) << from << " " << name;
      }
      expect_true(e, fmt::format("{} {}", from, name));
    }
  };
  row("inspect", inspected);
  row("tune", tuned);
}

// Fixed ambiguities, half a minute of float ones, and fixed ones again. Errors of float fixes are nearly all slow, and
// those of fixed ones nearly all white: one share of what is stated does for neither.
TEST(FloatBetweenFixed, IsToldByInspect) {
  const int runs = seeds(1, 20);
  Both errors;
  for (int k = 1; k <= runs; ++k) {
    Case c = make_case("ski", 250, static_cast<std::uint64_t>(900 + k), [&](Scenario& s) {
      s.imus[0].clock_offset = s.imus[0].clock_drift = 0;
      s.gnss[0].rate = 8;
      s.gnss[0].position_noise.setConstant(0.015);
      s.gnss[0].velocity_noise.setZero();
      s.motion.run = 150;
    });
    constexpr double kStated = 0.35, kTime = 12, kWhite = 0.04, kBegin = 60, kEnd = 95;
    Random random(static_cast<std::uint64_t>(k));
    Vector3d slow = random.vector(kStated);
    double last = 0;
    for (GeodeticFix& fix : c.simulation.gnss[0].fixes) {
      const double since = fix.time - c.under_way();
      if (since < kBegin || since > kEnd) continue;
      const double stays = last == 0 ? 1 : std::exp(-(fix.time - last) / kTime);
      last = fix.time;
      slow = stays * slow + random.vector(kStated * std::sqrt(1 - stays * stays));
      const World there(fix.position);
      fix.position = there.to_geodetic(slow + random.vector(kWhite));
      fix.sigma_position.setConstant(kStated);
    }
    const TemporaryFolder folder;
    const ReplayConfig config = inspected_config(folder, c);
    ASSERT_TRUE(config.filter.gnss[0].drift.has_value()) << k;
    EXPECT_LT(config.filter.gnss[0].drift->most_white, 0.3) << k;
    const Replay replayed = replay(config);
    errors.filtered.add(replayed.filtered.solution, c, replayed.options);
    errors.smoothed.add(*replayed.smoothed, c, replayed.options);
  }
  for (const auto& [name, e] : {std::pair("filtered", errors.filtered), std::pair("smoothed", errors.smoothed)}) {
    fmt::print("{}: {:.1f} % inside 3 sigma, mean square {:.2f}\n", name, 100 * e.within(), e.mean_square());
    EXPECT_GE(e.within(), 0.97) << name;
    EXPECT_LT(e.mean_square(), 1.5) << name;
  }
}

std::vector<SlowReceiver> slow_receivers() {
  std::vector<SlowReceiver> all;
  for (const bool velocities : {true, false}) {
    const double l1 = velocities ? 0.1 : 0, rtk = velocities ? 0.025 : 0;
    all.push_back({"L1", 4, 0.4, {{0.4, 0.4, 0.4}, 60}, l1, velocities});
    for (const double time : {20., 60., 300.}) {
      all.push_back(
          {fmt::format("Rtk{:.0f}s", time), 10, 0.005, {{0.01, 0.01, 0.01}, time}, rtk, time == 60 && !velocities});
    }
  }
  return all;
}

INSTANTIATE_TEST_SUITE_P(SlowReceiver, SlowReceivers, ::testing::ValuesIn(slow_receivers()),
                         [](const auto& all) { return all.param.whole_name(); });

}  // namespace
}  // namespace piste::test
