// The sums over runs say what was put in: true covariances and false ones, white innovations and correlated ones.

#include "piste/consistency/consistency.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "piste/core/error.h"
#include "support/ensemble.h"

namespace piste {
namespace {

using test::added;
using test::drawn_run;
using test::Ensemble;

constexpr auto kRest = static_cast<std::size_t>(Phase::kRest);
constexpr auto kUnderWay = static_cast<std::size_t>(Phase::kUnderWay);
constexpr auto kRestAfter = static_cast<std::size_t>(Phase::kRestAfter);

/// Of `value` from `truth`, in standard errors.
double apart(double value, double truth, double standard_error) { return std::abs(value - truth) / standard_error; }

TEST(Consistency, FindsTrueCovariancesTrue) {
  const Ensemble ensemble;
  const ConsistencyReport report = added(ensemble).report();
  EXPECT_TRUE(report.consistent());
  EXPECT_TRUE(report.outside().empty());
  EXPECT_EQ(report.runs, ensemble.runs);
  for (const EstimatorConsistency* e : {&report.filter, &report.smoother}) {
    for (const std::size_t phase : {kRest, kUnderWay, kRestAfter}) {
      ASSERT_EQ(e->groups[phase].size(), report.groups.size());
      for (std::size_t g = 0; g < report.groups.size(); ++g) {
        const GroupConsistency& found = e->groups[phase][g];
        SCOPED_TRACE(report.groups[g].name);
        EXPECT_LT(apart(found.nees, 1, found.standard_error), 4);
        // That of a mean of χ² variables; it is itself known to 1 / sqrt(2 runs), about a tenth.
        const double epochs = phase == kUnderWay ? 41 : 10;
        const double expected = std::sqrt(2 / (static_cast<double>(report.groups[g].rows.size()) * epochs * 60));
        EXPECT_NEAR(found.standard_error / expected, 1, 0.5);
        EXPECT_NEAR(found.coverage[0], 0.6827, 0.03);
        EXPECT_NEAR(found.coverage[1], 0.9545, 0.015);
        EXPECT_NEAR(found.coverage[2], 0.9973, 0.005);
        EXPECT_GT(found.largest, 2.5);
        EXPECT_LT(found.largest, 6);
        EXPECT_LE(found.outside, 0.1);
      }
      for (const BlockAccuracy& found : e->blocks[phase]) {
        EXPECT_LT(apart(found.ratio, 1, found.standard_error), 4);
        EXPECT_NEAR(found.claimed / found.bound, 1, 1e-12);
        EXPECT_NEAR(found.rmse / found.bound, found.ratio, 1e-12);
      }
    }
  }
  const auto position = report.filter.blocks[kUnderWay].front();
  EXPECT_NEAR(position.bound, 0.5 * std::sqrt(3), 1e-12);
  EXPECT_NEAR(report.smoother.blocks[kUnderWay].front().bound, position.bound / std::sqrt(2), 1e-12);
}

TEST(Consistency, FindsFalseCovariancesFalse) {
  for (const double claimed : {0.5, 2.0}) {
    const ConsistencyReport report = added({.runs = 30, .claimed = claimed}).report();
    EXPECT_FALSE(report.consistent());
    const auto& whole = report.filter.groups[kUnderWay].front();
    EXPECT_LT(apart(whole.nees, 1 / claimed, whole.standard_error), 4);
    EXPECT_FALSE(report.bands.front().contains(whole.nees));
    EXPECT_EQ(whole.outside, 1);
    EXPECT_EQ(report.outside().size(), 2 * report.groups.size());
    EXPECT_EQ(report.outside().front(), "filter whole");
    // What is claimed does not move the errors.
    const BlockAccuracy& velocity = report.filter.blocks[kUnderWay][1];
    EXPECT_LT(apart(velocity.ratio, 1, velocity.standard_error), 4);
    EXPECT_NEAR(velocity.claimed / velocity.bound, std::sqrt(claimed), 1e-12);
  }
}

// The band of one epoch is wide; the mean over a run's epochs is known far better, and its test uses that.
TEST(Consistency, FindsWhatTheBandOfOneEpochDoesNotShow) {
  const ConsistencyReport report = added({.runs = 20, .claimed = 0.9}).report();
  const GroupConsistency& failed =
      *std::ranges::find_if(report.filter.groups[kUnderWay], [](const GroupConsistency& g) { return !g.test.holds; });
  EXPECT_LT(failed.test.p_value, 1e-3);
  EXPECT_FALSE(report.consistent());
  EXPECT_TRUE(report.bands.front().contains(report.filter.groups[kUnderWay].front().nees));
}

// Two per cent are significant over so many epochs, and nobody would act on them.
TEST(Consistency, LetsASmallDifferencePass) {
  const ConsistencyReport report = added({.runs = 400, .claimed = 0.98}).report();
  EXPECT_TRUE(report.consistent());
  const GroupConsistency& whole = report.filter.groups[kUnderWay].front();
  EXPECT_LT(whole.test.p_value, 1e-3);
  EXPECT_TRUE(whole.test.holds);
}

TEST(Consistency, KeepsThePhasesApart) {
  const EpochGrid grid = Ensemble{}.grid;
  EXPECT_EQ(grid.phase(-0.1), Phase::kRest);
  EXPECT_EQ(grid.phase(0), std::nullopt);
  EXPECT_EQ(grid.phase(4.9), std::nullopt);
  EXPECT_EQ(grid.phase(5), Phase::kUnderWay);
  EXPECT_EQ(grid.phase(45), Phase::kUnderWay);
  EXPECT_EQ(grid.phase(50), std::nullopt);
  EXPECT_EQ(grid.phase(50.1), Phase::kRestAfter);
  EXPECT_EQ(grid.interval(Phase::kRest)->start, -10);
  EXPECT_EQ(grid.interval(Phase::kRest)->end, -1);
  EXPECT_EQ(grid.interval(Phase::kRestAfter)->start, 51);
  EXPECT_EQ(EpochGrid{}.interval(Phase::kUnderWay)->end, 0);
  EXPECT_FALSE(EpochGrid{}.interval(Phase::kRest));

  const ConsistencyReport report = added({.runs = 30, .claimed_rest = 0.5}).report();
  EXPECT_TRUE(report.consistent()) << "what is judged is under way";
  EXPECT_NEAR(report.filter.groups[kRest].front().nees, 2, 0.1);
  EXPECT_NEAR(report.filter.groups[kUnderWay].front().nees, 1, 0.05);
  EXPECT_NEAR(report.filter.nees.front()[0], 2, 0.4);
  EXPECT_NEAR(report.filter.nees.front()[30], 1, 0.2);
}

TEST(Consistency, DoesWithTheEpochsThatAreThere) {
  const Ensemble ensemble{.runs = 20};
  Consistency sums(ensemble.grid);
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    ComparedRun run = drawn_run(ensemble, seed);
    // No run knows epoch 7, half of them know epoch 8; nobody is smoothed, and nobody rests afterwards.
    std::erase_if(run.filtered, [&](const ErrorSample& s) {
      return s.epoch == 7 || (s.epoch == 8 && seed % 2 == 0) || s.epoch > 50;
    });
    run.smoothed.clear();
    sums.add(run);
  }
  const ConsistencyReport report = sums.report();
  const std::size_t seven = 7 - ensemble.grid.first;
  EXPECT_TRUE(std::isnan(report.filter.nees.front()[seven]));
  EXPECT_TRUE(std::isnan(report.filter.accuracy.front()[seven].rmse));
  EXPECT_NEAR(report.filter.nees.front()[seven + 1], 1, 0.4);
  EXPECT_NEAR(report.filter.groups[kUnderWay].front().nees, 1, 0.06);
  EXPECT_TRUE(report.filter.groups[kRestAfter].empty());
  EXPECT_TRUE(report.smoother.groups[kUnderWay].empty());
  EXPECT_FALSE(report.consistent()) << "the smoother was not seen";
}

TEST(Consistency, FindsTheHeadingThatWasFound) {
  const ConsistencyReport report = added({.runs = 40}).report();
  EXPECT_EQ(report.heading.time, 5);
  EXPECT_EQ(report.heading.runs, 40);
  EXPECT_NEAR(report.heading.rmse, 0.01, 0.004);
  EXPECT_NEAR(report.heading.largest_sigma, 0.01, 1e-12);
  EXPECT_NEAR(report.heading.largest, report.heading.largest_ratio * 0.01, 1e-12);
}

TEST(Innovations, WhiteOnesAreFoundWhite) {
  const ConsistencyReport report = added({.runs = 20}).report();
  ASSERT_EQ(report.sources.size(), 2U) << "a source that measured nothing is not judged";
  for (const SourceConsistency& source : report.sources) {
    SCOPED_TRACE(source.name);
    EXPECT_EQ(source.count, 20 * 401) << "under way, 10 a second";
    EXPECT_TRUE(source.band.contains(source.nis));
    for (int i = 0; i < source.dof; ++i) {
      EXPECT_LT(std::abs(source.autocorrelation[static_cast<std::size_t>(i)]), source.autocorrelation_band);
    }
    EXPECT_NEAR(source.autocorrelation_band, 3.2905 / std::sqrt(20 * 400), 1e-5);
  }
  EXPECT_EQ(report.sources[0].dof, 3);
  EXPECT_EQ(report.sources[1].dof, 1);
  EXPECT_NEAR(report.sources[0].rejected / report.sources[0].count, 0.001, 0.001);
}

TEST(Innovations, CorrelatedOnesAreFoundCorrelated) {
  const ConsistencyReport report = added({.runs = 10, .whiteness = 0.3}).report();
  for (const double r : report.sources[0].autocorrelation) EXPECT_NEAR(r, 0.3, 0.05);
  EXPECT_GT(0.2, report.sources[0].autocorrelation_band);
  EXPECT_LT(std::abs(report.sources[1].autocorrelation[0]), report.sources[1].autocorrelation_band);
}

TEST(SavedSums, GoOnWhereTheyStopped) {
  const Ensemble ensemble{.runs = 6};
  Consistency sums(ensemble.grid);
  // Saved and restored after every run, the first of which failed.
  sums.add_failure({7, "7: the filter has lost its way"});
  for (std::uint64_t seed = 1; seed <= 6; ++seed) {
    const std::string bytes = sums.save();
    Consistency restored = Consistency::restore(bytes);
    EXPECT_EQ(restored.save(), bytes);
    EXPECT_EQ(restored.size(), seed);
    restored.add(drawn_run(ensemble, seed));
    sums = restored;
  }
  Consistency at_once = added(ensemble);
  at_once.add_failure({7, "7: the filter has lost its way"});
  EXPECT_EQ(sums.save(), at_once.save());
  const ConsistencyReport a = sums.report(), b = at_once.report();
  EXPECT_EQ(a.filter.nees.back(), b.filter.nees.back());
  EXPECT_EQ(a.smoother.groups[kUnderWay][2].standard_error, b.smoother.groups[kUnderWay][2].standard_error);
  EXPECT_EQ(a.failures.front().what, "7: the filter has lost its way");
  EXPECT_FALSE(a.consistent()) << "a run failed";
}

TEST(SavedSums, AreRefusedWhereTheyAreNotWhole) {
  Consistency sums = added({.runs = 2, .grid = {.step = 10, .first = -1, .last = 4, .cruise = {5, 45}, .arrival = 50}});
  sums.add_failure({3, "a"});
  sums.add_failure({4, "b"});
  const std::string bytes = sums.save();
  for (std::size_t size = 0; size < bytes.size(); ++size) {
    EXPECT_THROW(Consistency::restore(std::string_view(bytes).substr(0, size)), DataError) << size;
  }
  EXPECT_THROW(Consistency::restore(bytes + "more"), DataError);
  EXPECT_THROW(Consistency::restore("piste consistency 0\n"), DataError);
  // Another grid than that of the tables: the last epoch stands 12 bytes after the head.
  std::string other = bytes;
  ++other[other.find('\n') + 1 + sizeof(double) + sizeof(int)];
  EXPECT_THROW(Consistency::restore(other), DataError);
}

TEST(Consistency, AddsOnlyLikeToLike) {
  const Ensemble ensemble{.runs = 1};
  Consistency sums = added(ensemble);
  ComparedRun run = drawn_run(ensemble, 2);
  run.sources.pop_back();
  EXPECT_THROW(sums.add(run), DataError);
}

}  // namespace
}  // namespace piste
