// An ensemble gives the same bytes however it was run, counts what fails, and its bound is one.

#include "piste/trial/ensemble.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <string>

#include "piste/core/error.h"
#include "support/scenario.h"

namespace piste::test {
namespace {

Scenario tiny() {
  Scenario s = suite_scenario("bicycle_l1l2");
  shorten(s, 3, 13, 1);
  return s;
}

std::string ran(const Scenario& s, std::size_t runs, std::size_t jobs) {
  Ensemble ensemble(s);
  ensemble.run(runs, jobs);
  return ensemble.save();
}

TEST(Ensemble, SameBytesWhateverTheJobs) {
  const Scenario s = tiny();
  const std::string one = ran(s, 5, 1);
  EXPECT_EQ(one, ran(s, 5, 2));
  EXPECT_EQ(one, ran(s, 5, 7));
  EXPECT_EQ(one, ran(s, 5, 0));  // none at a time is one
  EXPECT_NE(one, ran(s, 4, 2));
}

TEST(Ensemble, GoesOnWhereItWasStopped) {
  const Scenario s = tiny();
  const std::string stopped = ran(s, 2, 2);
  Ensemble ensemble(s);
  ASSERT_TRUE(ensemble.resume(stopped));
  EXPECT_EQ(ensemble.size(), 2U);
  int added = 0;
  ensemble.run(5, 2, [&](const Ensemble&) { ++added; });
  EXPECT_EQ(added, 3);
  EXPECT_EQ(ensemble.save(), ran(s, 5, 1));
}

TEST(Ensemble, PartsMergeToTheBytesOfTheWhole) {
  const Scenario s = tiny();
  const auto part = [&](std::size_t first, std::size_t runs) {
    Ensemble ensemble(s, {}, first);
    ensemble.run(runs, 2);
    return ensemble.save();
  };
  Ensemble merged(s);
  for (const std::string& bytes : {part(0, 1), part(1, 3), part(4, 1)}) merged.append(bytes);
  EXPECT_EQ(merged.save(), ran(s, 5, 1));
  EXPECT_THROW(merged.append(part(4, 1)), DataError);
  Scenario other = s;
  other.text += "\n";
  EXPECT_THROW(Ensemble(other).append(part(0, 1)), DataError);
}

TEST(Ensemble, GoesOnWithNothingElse) {
  const Scenario s = tiny();
  const std::string saved = ran(s, 1, 1);
  Scenario other = s;
  other.replay.sensor.gyro.noise *= 1.01;
  EXPECT_FALSE(Ensemble(other).resume(saved));
  EXPECT_FALSE(Ensemble(s).resume(saved.substr(0, saved.size() / 2)));
  EXPECT_FALSE(Ensemble(s).resume(""));
  EXPECT_FALSE(Ensemble(s).resume(std::string(1000, 'x')));
}

TEST(Ensemble, ThrowsOnWhatTheObserverThrows) {
  for (const std::size_t jobs : {1U, 2U}) {
    Ensemble ensemble(tiny());
    const auto full_disk = [](const Ensemble& so_far) {
      if (so_far.size() == 2) throw Error("disk", "is full");
    };
    EXPECT_THROW(ensemble.run(6, jobs, full_disk), Error);
    EXPECT_EQ(ensemble.size(), 2U);
  }
}

TEST(Ensemble, CountsTheRunsThatFail) {
  Scenario s = tiny();
  s.replay.heading = ReplaySetup::Heading::kAuto;
  s.replay.outages = {{-3, 14}};
  Ensemble ensemble(s);
  ensemble.run(3, 2);
  EXPECT_EQ(ensemble.size(), 3U);
  const ConsistencyReport report = ensemble.sums().report();
  EXPECT_EQ(report.runs, 0);
  ASSERT_EQ(report.failures.size(), 3U);
  EXPECT_EQ(report.failures.front().seed, s.seed);
  EXPECT_NE(report.failures.front().what.find("GNSS"), std::string::npos) << report.failures.front().what;
  EXPECT_FALSE(report.consistent());
}

// A run from the truth with perfect sensors stays there, so that what the bound is linearised at is the truth.
TEST(Trial, BoundIsThatOfTheSensorsAndNotOfWhatTheFilterIsTold) {
  Scenario s = tiny();
  const ComparedRun honest = run_trial(s, 1);
  s.replay.sensor.accel.bias *= 0.1;
  const ComparedRun optimistic = run_trial(s, 1);
  ASSERT_EQ(honest.filtered.size(), optimistic.filtered.size());
  const ErrorSample &a = honest.filtered.back(), &b = optimistic.filtered.back();
  EXPECT_TRUE(a.bound == b.bound);
  const int bias = honest.layout.offset(Block::kAccelBias);
  EXPECT_LT(b.P(bias, bias), 0.2 * b.bound(bias));
  for (int i = 0; i < honest.layout.size(); ++i) {
    EXPECT_NEAR(std::sqrt(a.P(i, i) / a.bound(i)), 1, 0.1) << "row " << i;
  }
}

TEST(Trial, SmoothingNeverRaisesTheBound) {
  const ComparedRun run = run_trial(tiny(), 1);
  std::size_t compared = 0;
  double lowest = 1;
  for (const ErrorSample& smoothed : run.smoothed) {
    for (const ErrorSample& filtered : run.filtered) {
      if (filtered.epoch != smoothed.epoch) continue;
      ++compared;
      EXPECT_TRUE((smoothed.bound.array() <= filtered.bound.array() * (1 + 1e-9)).all()) << filtered.epoch;
      lowest = std::min(lowest, (smoothed.bound.array() / filtered.bound.array()).minCoeff());
    }
  }
  EXPECT_EQ(compared, run.filtered.size());
  EXPECT_GE(compared, 14U);
  EXPECT_LT(lowest, 0.5) << "the smoother had nothing to do";
}

}  // namespace
}  // namespace piste::test
