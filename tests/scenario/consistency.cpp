/// Are the sigmas true? NEES of simulated runs, filter and smoother, against its chi-squared band; and out of the band
/// when the simulated sensor is worse than its file says.

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <ostream>

#include "support/monte_carlo.h"

namespace piste::test {
namespace {

constexpr int kRuns = 50;
constexpr double kRest = 20, kRun = 35, kAfter = 2;
constexpr double kUnderWay = 9;  // s after the start: cruising, heading known

struct Group {
  std::string name;
  std::vector<Block> blocks;
};

std::vector<Group> groups(const StateLayout& layout) {
  std::vector<Group> all{{"whole", layout.blocks()},
                         {"biases", {Block::kGyroBias, Block::kAccelBias, Block::kGyroDrift, Block::kAccelDrift}},
                         {"scales", {Block::kGyroScale, Block::kAccelScale}}};
  for (const Block b : layout.blocks()) all.push_back({std::string(info(b).name), {b}});
  return all;
}

// The table of one experiment, printed, and how many of its means lie outside their band.
int outside(const std::string& title, const std::vector<ReplayedRun>& runs) {
  int count = 0;
  fmt::print("{}: NEES / dof over {} runs\n  {:20} {:>8} {:>8}   {:14}  beyond 3 sigma\n", title, runs.size(), "",
             "filter", "smoother", "99.9 % band");
  for (const Group& g : groups(runs.front().layout)) {
    const Consistency f = consistency(runs, false, g.blocks, kUnderWay, kRun);
    const Consistency s = consistency(runs, true, g.blocks, kUnderWay, kRun);
    count += !f.within() + !s.within();
    fmt::print("  {:20} {:7.3f}{} {:7.3f}{}  [{:.3f}, {:.3f}]  {:.2f} % {:.2f} %\n", g.name, f.mean,
               f.within() ? ' ' : '*', s.mean, s.within() ? ' ' : '*', f.low, f.high, 100 * f.beyond, 100 * s.beyond);
  }
  return count;
}

struct Case {
  std::string scenario, receiver;
};
void PrintTo(const Case& c, std::ostream* out) { *out << c.scenario << ", " << c.receiver; }

class Consistent : public ::testing::TestWithParam<Case> {};

TEST_P(Consistent, EveryBlockIsWithinItsBand) {
  const auto& [scenario, receiver] = GetParam();
  const auto runs = replay_all(experiment(scenario, receiver, kRest, kRun, kAfter), kRuns);
  EXPECT_EQ(outside(scenario + ", " + receiver, runs), 0);
}

INSTANTIATE_TEST_SUITE_P(Scenarios, Consistent,
                         ::testing::Values(Case{"ski", "gnss_l1l2"}, Case{"giant_slalom", "gnss_l1l2"},
                                           Case{"bicycle", "gnss_l1l2"}, Case{"ski", "gnss_l1"}),
                         [](const auto& c) { return c.param.scenario + "_" + c.param.receiver; });

// The test can fail: a sensor with twice the noise that its file says.
TEST(Inconsistent, TwiceTheNoiseLeavesTheBand) {
  for (const bool gyro : {true, false}) {
    Experiment e = experiment("ski", "gnss_l1l2", kRest, kRun, kAfter);
    ImuSensor& sensor = e.scenario.imus.front().sensor;
    (gyro ? sensor.gyro : sensor.accel).noise *= 2;
    const auto runs = replay_all(e, kRuns / 2);
    outside(gyro ? "gyro noise doubled" : "accelerometer noise doubled", runs);
    const auto& all = runs.front().layout.blocks();
    EXPECT_GT(consistency(runs, false, all, kUnderWay, kRun).mean, consistency(runs, false, all, kUnderWay, kRun).high);
    EXPECT_GT(consistency(runs, true, all, kUnderWay, kRun).mean, consistency(runs, true, all, kUnderWay, kRun).high);
  }
}

// Seeds whose gyro bias, not yet known, once made the first seconds of rest look like motion: the heading came out
// 130 deg wrong, with 6 deg claimed.
TEST(UnknownHeading, IsNotFoundInARest) {
  Experiment e = experiment("giant_slalom", "gnss_l1l2", kRest, kRun, kAfter);
  e.find_heading = true;
  for (const std::uint64_t seed : {8u, 16u}) {
    const ReplayedRun run = replay(e, seed);
    for (const ErrorSample& s : run.filtered) {
      EXPECT_LT(s.error.segment<3>(run.layout.offset(Block::kAttitude)).norm(), 10 / kDegreesPerRadian)
          << "seed " << seed << " at " << s.time << " s of the run";
    }
  }
}

}  // namespace
}  // namespace piste::test
