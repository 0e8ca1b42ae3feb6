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

TEST(Warnings, OfWhatIsTooMuchForOutliers) {
  Solution solution;
  solution.sources = {"gnss[0].position", "attitude[0]", "rest.velocity", "gnss[1].position"};
  add(solution, 0, 100, 2);  // outliers
  add(solution, 1, 100, 21);
  add(solution, 2, 19, 19);  // too few to tell
  add(solution, 3, 100, 6);
  const std::vector<std::string> warnings = warnings_of(solution);
  ASSERT_EQ(warnings.size(), 2U);
  EXPECT_TRUE(warnings[0].starts_with("21 of 100 measurements of attitude[0] were rejected")) << warnings[0];
  EXPECT_TRUE(contains(warnings[1], "gnss[1].position contradicted the rest, by 5 m at first")) << "over 5 s";
}

TEST(Warnings, NoneOfARunThatWentWell) {
  Solution solution;
  solution.sources = {"gnss[0].position"};
  add(solution, 0, 100, 0);
  EXPECT_TRUE(warnings_of(solution).empty());
}

}  // namespace
}  // namespace piste::test
