#include "search/work.h"

#include <gtest/gtest.h>

#include <string>
#include <utility>
#include <vector>

namespace piste::test {
namespace {

struct Heard {
  std::vector<std::pair<std::string, double>> told;
  Work work{[this](std::string_view stage, double part) { told.emplace_back(stage, part); }};
  double now() const { return told.back().second; }
};

TEST(Work, StepsHaveTheSharesOfTheirCosts) {
  Heard h;
  h.work.expect(100);
  const ProgressCallback reading = h.work.step("reading", 20);
  EXPECT_EQ(h.now(), 0);
  reading(0.5);
  EXPECT_DOUBLE_EQ(h.now(), 0.1);
  const ProgressCallback search = h.work.step("search", 80);
  EXPECT_DOUBLE_EQ(h.now(), 0.2);
  EXPECT_EQ(h.told.back().first, "search");
  search(1);
  EXPECT_DOUBLE_EQ(h.now(), 1);
  h.work.finish();
  EXPECT_EQ(h.now(), 1);
}

// What turns out to be needed besides makes it go on more slowly, and what is not needed faster; it never goes back.
TEST(Work, NeverGoesBack) {
  Heard h;
  h.work.expect(100);
  h.work.step("a", 50)(1);
  h.work.expect_more(150);  // 200 are left, for the half that is left
  const ProgressCallback b = h.work.step("b", 100);
  EXPECT_DOUBLE_EQ(h.now(), 0.5);
  b(0.6);
  EXPECT_DOUBLE_EQ(h.now(), 0.65);
  b(0.2);
  EXPECT_DOUBLE_EQ(h.now(), 0.65);
  h.work.expect(10);  // most of the rest is not needed
  h.work.step("c", 5)(0);
  EXPECT_DOUBLE_EQ(h.now(), 0.75);
  h.work.step("d", 500)(0);  // was not expected
  EXPECT_LE(h.now(), 1);
  h.work.finish();
  EXPECT_EQ(h.now(), 1);
  for (std::size_t i = 1; i < h.told.size(); ++i) EXPECT_GE(h.told[i].second, h.told[i - 1].second);
}

TEST(Work, OfNobodyTellsNobody) {
  const Work work;
  work.expect(1);
  EXPECT_FALSE(work.step("a", 1));
  work.finish();
}

}  // namespace
}  // namespace piste::test
