#include "piste/consistency/warnings.h"

#include <gtest/gtest.h>

#include "support/text_file.h"

namespace piste::test {
namespace {

// So many measurements of a source, a second apart, of which the first ones are rejected.
void add(Solution& solution, int source, int all, int rejected) {
  for (int i = 0; i < all; ++i) {
    solution.innovations.push_back({.time = static_cast<double>(i),
                                    .source = source,
                                    .residual = {3, 4, 0},
                                    .sigma = Vector3d::Ones(),
                                    .outcome = i < rejected ? Outcome::kRejected : Outcome::kUsed});
  }
}

TEST(Warnings, OfReceiversThatContradictedTheRest) {
  Solution solution;
  solution.sources = {"gnss[0].position", "attitude[0]", "gnss[1].position"};
  add(solution, 0, 100, 2);   // outliers
  add(solution, 1, 100, 21);  // no receiver
  add(solution, 2, 100, 6);
  const std::vector<std::string> warnings = warnings_of(solution);
  ASSERT_EQ(warnings.size(), 1U);
  EXPECT_TRUE(contains(warnings[0], "gnss[1].position contradicted the rest, by 5 m at first")) << "over 5 s";
}

TEST(Warnings, ManyOfOneSourceAreToldTogether) {
  Solution solution;
  solution.sources = {"gnss[0].position", "gnss[0].velocity"};
  for (int times = 0; times < 9; ++times) {
    add(solution, 0, 20, 6);
    for (Innovation& i : solution.innovations) i.time += i.source == 0 ? 20 : 0;
  }
  add(solution, 1, 100, 6);
  const std::vector<std::string> warnings = warnings_of(solution);
  ASSERT_EQ(warnings.size(), 7U);
  EXPECT_TRUE(contains(warnings.back(), "gnss[0].position was left out 4 more times until")) << warnings.back();
  EXPECT_TRUE(contains(warnings.back(), ", 24 fixes in all of them")) << warnings.back();
}

TEST(Warnings, NoneOfARunThatWentWell) {
  Solution solution;
  solution.sources = {"gnss[0].position"};
  add(solution, 0, 100, 0);
  EXPECT_TRUE(warnings_of(solution).empty());
}

}  // namespace
}  // namespace piste::test
