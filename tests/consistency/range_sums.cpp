// Sums over a range of runs are the same bytes however the range was cut.

#include "piste/consistency/range_sums.h"

#include <gtest/gtest.h>

#include <random>
#include <vector>

#include "piste/core/error.h"
#include "support/ensemble.h"

namespace piste::test {
namespace {

// Runs with numbers of any size, so that another order of additions shows.
std::vector<Consistency> single_runs(std::size_t count) {
  const Ensemble ensemble;
  std::vector<Consistency> runs;
  for (std::size_t i = 0; i < count; ++i) {
    Consistency one(ensemble.grid);
    if (i % 7 == 3) {
      one.add_failure({i, "no fix"});
    } else {
      one.add(drawn_run(ensemble, i + 1));
    }
    runs.push_back(std::move(one));
  }
  return runs;
}

RangeSums range(const std::vector<Consistency>& runs, std::size_t first, std::size_t end) {
  RangeSums sums(runs.front().grid(), first);
  for (std::size_t i = first; i < end; ++i) sums.add(runs[i]);
  return sums;
}

TEST(RangeSums, SameBytesHoweverCut) {
  const std::vector<Consistency> runs = single_runs(37);
  const std::string whole = range(runs, 0, runs.size()).save();
  std::mt19937 random(1);
  for (int trial = 0; trial < 50; ++trial) {
    RangeSums sums(runs.front().grid());
    while (sums.end() < runs.size()) {
      const std::size_t last = std::min(runs.size(), sums.end() + 1 + random() % 12);
      sums.append(RangeSums::restore(range(runs, sums.end(), last).save()));
    }
    EXPECT_EQ(sums.save(), whole);
  }
}

TEST(RangeSums, TotalIsTheSum) {
  const std::vector<Consistency> runs = single_runs(13);
  Consistency plain(runs.front().grid());
  for (const Consistency& one : runs) plain.append(one);
  const ConsistencyReport expected = plain.report(), found = range(runs, 0, 13).total().report();
  EXPECT_EQ(found.runs, expected.runs);
  EXPECT_EQ(found.failures.size(), 2U);
  EXPECT_EQ(found.failures.back().seed, 10U);
  const auto& a = found.filter.groups[1];
  const auto& b = expected.filter.groups[1];
  ASSERT_EQ(a.size(), b.size());
  for (std::size_t g = 0; g < a.size(); ++g) {
    EXPECT_NEAR(a[g].nees, b[g].nees, 1e-13 * b[g].nees);
    EXPECT_EQ(a[g].largest, b[g].largest);
    EXPECT_EQ(a[g].largest_seed, b[g].largest_seed);
  }
  ASSERT_FALSE(found.sources.empty());
  EXPECT_EQ(found.sources.front().dof, expected.sources.front().dof);
  EXPECT_EQ(found.sources.front().count, expected.sources.front().count);
}

// The run with the largest error can be simulated again by itself.
TEST(RangeSums, KnowTheSeedOfTheWorstRun) {
  const Ensemble ensemble;
  RangeSums sums(ensemble.grid);
  for (std::uint64_t seed = 1; seed <= 9; ++seed) {
    ComparedRun run = drawn_run(ensemble, seed);
    if (seed == 6) run.filtered[30].error *= 100;
    Consistency one(ensemble.grid);
    one.add(run);
    sums.add(std::move(one));
  }
  constexpr auto kUnderWay = static_cast<std::size_t>(Phase::kUnderWay);
  const ConsistencyReport report = sums.total().report();
  for (const GroupConsistency& group : report.filter.groups[kUnderWay]) {
    EXPECT_GT(group.largest, 10);
    EXPECT_EQ(group.largest_seed, 6U);
  }
  EXPECT_LT(report.smoother.groups[kUnderWay].front().largest, 6);
}

TEST(RangeSums, RefusesWhatDoesNotFollow) {
  const std::vector<Consistency> runs = single_runs(6);
  RangeSums sums = range(runs, 0, 2);
  EXPECT_THROW(sums.append(range(runs, 3, 5)), DataError);
  EXPECT_THROW(sums.append(range(runs, 1, 5)), DataError);
  EXPECT_EQ(sums.size(), 2U);
  const std::string bytes = sums.save();
  for (std::size_t length = 0; length < bytes.size(); length += 97) {
    EXPECT_THROW(RangeSums::restore(std::string_view(bytes).substr(0, length)), DataError) << length;
  }
  EXPECT_THROW(RangeSums::restore(bytes + "x"), DataError);
}

TEST(RangeSums, RefusesOtherTimes) {
  const std::vector<Consistency> runs = single_runs(1);
  EpochGrid other = runs.front().grid();
  other.last -= 1;
  RangeSums sums(other);
  EXPECT_THROW(
      {
        sums.append(range(runs, 0, 1));
        Consistency total = sums.total();
      },
      DataError);
}

}  // namespace
}  // namespace piste::test
