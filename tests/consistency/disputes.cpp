// Series of fixes that were left out, from made-up innovations.

#include "piste/consistency/disputes.h"

#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "support/text_file.h"

namespace piste::test {
namespace {

/// Innovations of one source, a second apart: u used, r rejected, d disputed, a used again, e repeated.
Solution run_of(const std::string& source, const std::string& outcomes) {
  Solution s;
  s.sources = {source};
  for (const char c : outcomes) {
    const Outcome outcome = c == 'u'   ? Outcome::kUsed
                            : c == 'r' ? Outcome::kRejected
                            : c == 'd' ? Outcome::kDisputed
                            : c == 'a' ? Outcome::kReadmitted
                                       : Outcome::kRepeated;
    s.innovations.push_back({.time = static_cast<double>(s.innovations.size()),
                             .source = 0,
                             .dof = 2,
                             .residual = {3, 4, 100},
                             .sigma = Vector3d::Ones(),
                             .outcome = outcome});
  }
  return s;
}

TEST(Disputes, EndWhereTheSourceIsUsedAgain) {
  const Solution s = run_of("gnss[0].position", "uurrddduuddddarru");
  const std::vector<Dispute> found = disputes_of(s);
  ASSERT_EQ(found.size(), 2U) << "the last is too short";
  EXPECT_EQ(found[0].during.start, 2);
  EXPECT_EQ(found[0].during.end, 6);
  EXPECT_EQ(found[0].fixes, 5U);
  EXPECT_EQ(found[0].size, 5) << "of the rows that were measured";
  EXPECT_FALSE(found[0].believed);
  EXPECT_TRUE(found[1].believed);
  EXPECT_EQ(found[1].size, 0) << "none was outside the gate";
  EXPECT_EQ(disputes_of(s, 1).size(), 3U);
  EXPECT_EQ(disputes_of(run_of("gnss[0].position", "urrrrr")).size(), 1U) << "it lasts until the end";
}

TEST(Disputes, AreSaidInASentence) {
  const auto text = [](const std::string& source, const std::string& outcomes) {
    const Solution s = run_of(source, outcomes);
    return text_of(disputes_of(s).at(0), s);
  };
  EXPECT_EQ(text("gnss[0].position", "urrrrru"),
            "gnss[0].position contradicted the rest, by 5 m at first: 5 fixes from 1.000 s, over 4.0 s, were left out");
  EXPECT_TRUE(contains(text("gnss[0].velocity", "urrrrru"), ", by 5 m/s at first:"));
  EXPECT_TRUE(contains(text("rest.velocity", "urrrrru"), "rest.velocity contradicted the rest: 5 fixes"));
  EXPECT_TRUE(contains(text("attitude[0]", "urrrrru"), "attitude[0] contradicted the rest: 5 fixes"));
  EXPECT_TRUE(contains(text("gnss[0].position", "ueeeeeu"), "gnss[0].position repeated its last fix: 5 fixes"));
  EXPECT_TRUE(contains(text("gnss[0].position", "uddddda"), "; after that it was believed, and what came before"));
}

}  // namespace
}  // namespace piste::test
