#include "plot/heat_map.h"

#include <gtest/gtest.h>

#include <limits>

#include "report/well_formed.h"
#include "support/text_file.h"

namespace piste {
namespace {

using test::contains;

/// The cell whose number is `text`: all that stands before it and after the number before.
std::string cell_of(const std::string& svg, const std::string& text) {
  const std::size_t end = svg.find(">" + text + "<");
  return svg.substr(svg.rfind("<path", end), end - svg.rfind("<path", end));
}

TEST(HeatMap, TellsSignsAndSizesApart) {
  const HeatMap map{.title = "corr. & <more>",
                    .description = "",
                    .rows = {"one", "a longer <name>"},
                    .columns = {"fx", "fy"},
                    .values = {{0.96, -0.33}, {std::numeric_limits<double>::quiet_NaN(), 0.1}}};
  const std::string svg = map.render();
  EXPECT_EQ(test::not_well_formed(svg), "");
  for (const char* part :
       {"corr. &amp; &lt;more&gt;", "a longer &lt;name&gt;", ">fx<", ">0.96<", ">−0.33<", ">0.10<"}) {
    EXPECT_TRUE(contains(svg, part)) << part;
  }
  EXPECT_FALSE(contains(svg, "nan"));
  EXPECT_TRUE(contains(cell_of(svg, "0.96"), "var(--c0)\" opacity=\"0.578\""));
  EXPECT_TRUE(contains(cell_of(svg, "−0.33"), "var(--c1)\" opacity=\"0.225\""));
  EXPECT_TRUE(contains(cell_of(svg, "0.10"), "opacity=\"0.096\""));
}

TEST(HeatMap, OfNothing) { EXPECT_EQ(test::not_well_formed(HeatMap{.title = "nothing"}.render()), ""); }

}  // namespace
}  // namespace piste
