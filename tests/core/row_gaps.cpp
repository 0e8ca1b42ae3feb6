// Where rows are missing, by the clock of the whole log: real gaps, and stamps that only look like gaps.

#include "core/row_gaps.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "support/random.h"

namespace piste {
namespace {

using Times = std::vector<double>;

Times even(double period, std::size_t count) {
  Times time;
  for (std::size_t i = 0; i < count; ++i) time.push_back(100 + period * static_cast<double>(i));
  return time;
}

Times without(Times time, std::size_t first, std::size_t count) {
  const auto from = time.begin() + static_cast<std::ptrdiff_t>(first);
  time.erase(from, from + static_cast<std::ptrdiff_t>(count));
  return time;
}

Times rounded(Times time, double resolution) {
  for (double& t : time) t = resolution * std::round(t / resolution);
  return time;
}

TEST(RowGaps, HowLongAGapIsIsAnOption) {
  const Times time = without(even(0.01, 5000), 1200, 1);
  EXPECT_EQ(find_gaps(time).after.size(), 1u);
  EXPECT_EQ(find_gaps(time, {.long_interval = 2.5}).after.size(), 0u);
}

TEST(RowGaps, OneMissingRowIsFound) {
  const RowGaps gaps = find_gaps(without(even(0.01, 5000), 1200, 1));
  EXPECT_EQ(gaps.after, std::vector<std::size_t>{1200});
  EXPECT_NEAR(gaps.period, 0.01, 1e-12);
  EXPECT_TRUE(gaps.before(1200));
  EXPECT_FALSE(gaps.before(1199));
}

TEST(RowGaps, MissingRowsOfARoundedClockAreFound) {
  const RowGaps gaps = find_gaps(rounded(without(without(even(0.0075, 5000), 3000, 40), 1200, 1), 1e-3));
  EXPECT_EQ(gaps.after, (std::vector<std::size_t>{1200, 2999}));
  EXPECT_NEAR(gaps.period, 0.0075, 1e-6);
}

TEST(RowGaps, ManyMissingRowsDoNotChangeThePeriod) {
  test::Random random(3);
  Times time;
  std::size_t missing = 0;
  for (const double t : even(0.01, 20000)) {
    if (!time.empty() && random.uniform() < 0.1) {
      ++missing;
    } else {
      time.push_back(t);
    }
  }
  const RowGaps gaps = find_gaps(time);
  EXPECT_NEAR(gaps.period, 0.01, 1e-9);
  double rows = 0;
  for (const std::size_t i : gaps.after) rows += std::round((time[i] - time[i - 1]) / gaps.period) - 1;
  EXPECT_NEAR(rows, static_cast<double>(missing), 1);  // the last row may be one of them
}

TEST(RowGaps, StepsOfSixToNineMillisecondsAreNoGaps) {
  // A clock that counts milliseconds reads a sensor of 150 Hz now and then too late.
  test::Random random(1);
  Times time = even(1 / 150.0, 20000);
  for (double& t : time) t = 1e-3 * std::floor(1e3 * (t + 2.3e-3 * random.uniform()));
  double least = 1, most = 0;
  for (std::size_t i = 1; i < time.size(); ++i) {
    least = std::min(least, time[i] - time[i - 1]), most = std::max(most, time[i] - time[i - 1]);
  }
  ASSERT_NEAR(least, 4e-3, 1.1e-3);
  ASSERT_NEAR(most, 9e-3, 1.1e-3);
  EXPECT_EQ(find_gaps(time).after.size(), 0u);
}

TEST(RowGaps, LateAndBunchedStampsAreNoGaps) {
  Times late = even(0.01, 1000);
  late[400] += 0.0095, late[700] += 0.008;
  EXPECT_EQ(find_gaps(late).after.size(), 0u);
  Times bunched = even(0.01, 1000);  // eight rows arrive together
  for (std::size_t i = 0; i < bunched.size(); ++i) bunched[i] = bunched[i / 8 * 8] + 1e-4 * static_cast<double>(i % 8);
  const RowGaps gaps = find_gaps(bunched);
  EXPECT_EQ(gaps.after.size(), 0u);
  EXPECT_NEAR(gaps.period, 0.01, 1e-4);
}

TEST(RowGaps, AGapBesideLateStampsIsFound) {
  Times time = without(even(0.01, 1000), 500, 3);
  time[499] += 0.004, time[498] += 0.003, time[501] += 0.005;
  EXPECT_EQ(find_gaps(time).after, std::vector<std::size_t>{500});
}

TEST(RowGaps, ShortLogs) {
  EXPECT_EQ(find_gaps(Times{}).period, 0);
  EXPECT_EQ(find_gaps(Times{1}).period, 0);
  EXPECT_EQ(find_gaps(Times{1, 1.5}).period, 0.5);
  EXPECT_EQ(find_gaps(Times{0, 0.1, 0.2, 5, 5.1, 5.2}).after, std::vector<std::size_t>{3});
}

}  // namespace
}  // namespace piste
