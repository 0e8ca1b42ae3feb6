// The tables of a study against small cases by hand.

#include "piste/analyse/study_tables.h"

#include <gtest/gtest.h>

#include "support/study_case.h"

namespace piste {
namespace {

using test::StudyCase;

TEST(StudyCase, IsWholeUnlessItIsToFail) {
  const Study study = StudyCase{}.study();
  EXPECT_TRUE(missing(study).empty()) << missing(study).front();
  EXPECT_EQ(table_of(study, Method::kRest, Quantity::kBias).size(), 18U);
  EXPECT_EQ(before_after(study).size(), 18U);
  EXPECT_EQ(correlations(study).size(), 18U);
  EXPECT_EQ(timing(study).size(), 7U);
  EXPECT_EQ(ranking(study).rows.size(), kMethods.size());
  EXPECT_EQ(ranking(study).winner, Method::kMarkovSmoothed);
  EXPECT_EQ(missing(StudyCase{.failed = true}.study()).size(), 3U);
}

}  // namespace
}  // namespace piste
