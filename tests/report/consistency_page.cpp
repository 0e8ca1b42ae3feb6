// The page of an ensemble is whole, well-formed, escaped and needs nothing beside it.

#include "piste/report/consistency_page.h"

#include <gtest/gtest.h>

#include <cstdlib>
#include <fstream>

#include "plot/svg.h"
#include "report/well_formed.h"
#include "support/ensemble.h"
#include "support/text_file.h"

namespace piste {
namespace {

using test::added;
using test::contains;
using test::Ensemble;

/// From <main> on, which is XML as well.
TEST(ConsistencyPage, TellsEverythingInOneFile) {
  Consistency sums = added({.runs = 60, .claimed_rest = 0.6, .whiteness = 0.2});
  sums.add_failure({17, "run.yaml:3: <lost> & gone"});
  const std::string page =
      consistency_html(sums.report(), "ski & <bike>", "0.1.0", "imus: {file: <a>}\n</pre><script>");
  EXPECT_EQ(test::not_well_formed(test::body_of(page)), "");
  for (const char* part : {"<title>ski &amp; &lt;bike&gt;</title>",
                           "<h1>ski &amp; &lt;bike&gt;</h1>",
                           "Not consistent: 1 of 61 runs failed.",
                           "seed 17: run.yaml:3: &lt;lost&gt; &amp; gone",
                           "NEES per state: whole (21 states)",
                           "NEES per state: navigation (9 states)",
                           "NEES per state: biases (6 states)",
                           "NEES per state: scales (6 states)",
                           "RMSE of attitude",
                           "[deg]",
                           "[m/s]",
                           "smoother claimed",
                           "99.9 % band",
                           ".683",
                           "Under way <small>5 to 45 s</small>",
                           "At rest before the start",
                           "At rest after the stop",
                           "Innovations are not white at: gnss[0].position.",
                           "attitude[0]",
                           "How to read it",
                           "piste 0.1.0",
                           "imus: {file: &lt;a&gt;}\n&lt;/pre&gt;&lt;script&gt;"}) {
    EXPECT_TRUE(contains(page, part)) << part;
  }
  const std::string own = test::without_libraries(page);
  for (const char* wrong : {"src=", "<link", "href=\"http", "@import", "url(", "nan", "inf<", "<svg"}) {
    EXPECT_EQ(own.find(wrong), std::string::npos) << wrong;
  }
  EXPECT_LT(page.size(), 500'000U);
  // PISTE_SHOW=FILE keeps the page to be looked at.
  if (const char* file = std::getenv("PISTE_SHOW")) std::ofstream(file) << page;
}

TEST(ConsistencyPage, DoesWithoutSmootherAndInnovations) {
  const EpochGrid grid{.step = 5, .first = 0, .last = 0, .cruise = {0, 3}, .arrival = 4};
  ComparedRun run = test::drawn_run({.grid = grid}, 1);
  run.smoothed.clear();
  run.innovations.clear();
  Consistency sums(grid);
  sums.add(run);
  const std::string page = consistency_html(sums.report(), "one", "0.1.0", "");
  EXPECT_EQ(test::not_well_formed(test::body_of(page)), "");
  EXPECT_TRUE(contains(page, "the smoother was not seen under way"));
  const std::string own = test::without_libraries(page);
  for (const char* wrong : {"smoother NEES", "nan"}) EXPECT_EQ(own.find(wrong), std::string::npos) << wrong;
}

TEST(Svg, StrokesShadesAndLimits) {
  Plot plot("cut", {"x"}, {"y"});
  plot.line({0, 1, 2}, {0, 1, 1000}, 0, "dashed line", Plot::Stroke::kDashed);
  plot.shade(0, 1, 6, "shade");
  for (int i = 0; i < 12; ++i) plot.line({0, 1}, {0, 1}, i, "a legend of several rows");
  plot.limit_y(0, 2);
  const std::string svg = plot.render();
  EXPECT_EQ(test::not_well_formed(svg), "");
  EXPECT_TRUE(contains(svg, "stroke-dasharray"));
  EXPECT_TRUE(contains(svg, ">2.0<"));
  EXPECT_FALSE(contains(svg, ">1000<"));
  EXPECT_TRUE(contains(svg, "y=\"468.0\">a legend")) << "the last row stands where one row would";
}

}  // namespace
}  // namespace piste
