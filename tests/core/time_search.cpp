#include "core/time_search.h"

#include <gtest/gtest.h>

#include <vector>

namespace piste {
namespace {

struct Fix {
  double time;
};
const std::vector<Fix> kFixes{{1}, {2}, {2}, {3}};

TEST(TimeSearch, TheFirstAtOrAfterATime) {
  EXPECT_EQ(first_at_or_after(kFixes, 0) - kFixes.begin(), 0);
  EXPECT_EQ(first_at_or_after(kFixes, 2) - kFixes.begin(), 1);
  EXPECT_EQ(first_at_or_after(kFixes, 2.5) - kFixes.begin(), 3);
  EXPECT_EQ(first_at_or_after(kFixes, 3.5), kFixes.end());
}

TEST(TimeSearch, ARangeHoldsItsBeginningAndNotItsEnd) {
  EXPECT_EQ(range(kFixes, 1, 3).size(), 3U);
  EXPECT_EQ(range(kFixes, 1, 3).data(), kFixes.data());
  EXPECT_EQ(range(kFixes, 2, 2.5).size(), 2U);
  EXPECT_TRUE(range(kFixes, 2, 2).empty());
  EXPECT_TRUE(range(kFixes, 3, 1).empty());
  EXPECT_TRUE(range(std::vector<Fix>{}, 0, 1).empty());
}

TEST(TimeSearch, WhatTwoIntervalsHaveInCommon) {
  EXPECT_EQ(overlap({0, 3}, {1, 5}), 2);
  EXPECT_EQ(overlap({1, 5}, {0, 3}), 2);
  EXPECT_EQ(overlap({0, 9}, {2, 3}), 1);
  EXPECT_EQ(overlap({0, 1}, {2, 3}), 0);
}

}  // namespace
}  // namespace piste
