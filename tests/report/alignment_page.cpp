// The page of an alignment is whole, well-formed, escaped, and says what is not known.

#include "piste/report/alignment_page.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <fstream>
#include <limits>
#include <set>

#include "plot/svg.h"
#include "report/well_formed.h"
#include "support/alignment_picture.h"
#include "support/text_file.h"

namespace piste {
namespace {

using test::contains;

void expect_sound(const std::string& page) {
  EXPECT_EQ(test::not_well_formed(test::body_of(page)), "");
  const std::string own = test::without_libraries(page);
  for (const char* wrong : {"src=", "<link", "href=\"http", "@import", "url(", "nan", "inf<", ">inf"}) {
    EXPECT_EQ(own.find(wrong), std::string::npos) << wrong;
  }
}

TEST(AlignmentPage, TellsEverythingInOneFile) {
  const test::PictureOfRun run;
  const std::string page = alignment_html(run.picture());
  expect_sound(page);
  for (const char* part : {"<title>plate &amp; &lt;ski&gt;</title>",
                           "clock offset at the first sample [s]</th><td class=\"number\">2.50000</td>",
                           "clock drift [ppm]",
                           "boresight heading [deg]</th><td class=\"number\">2.8648",
                           "lever arm x [mm]",
                           "accel bias z [m/s²]",
                           "gyro scale x [ppm]</th><td class=\"number\">20000",
                           "Before: body IMU",
                           "Before: reference",
                           "After: the same seconds",
                           "0.990 at 2.500 s",
                           "The highest elsewhere is 0.400.",
                           "drift of 20.00 ppm",
                           "Angular rate along y, below 12 Hz",
                           "Specific force along z, below 12 Hz",
                           "Residual of specific force",
                           "noise in the sensor file",
                           "(deg/s)²/Hz",
                           "How to read it",
                           "imu: {file: &lt;a&gt;}\n&lt;/pre&gt;&lt;script&gt;"}) {
    EXPECT_TRUE(contains(page, part)) << part;
  }
  EXPECT_FALSE(contains(page, "not determine"));
  EXPECT_LT(page.size(), 600'000U);
  // PISTE_SHOW=FILE keeps the page to be looked at.
  if (const char* file = std::getenv("PISTE_SHOW")) std::ofstream(file) << page;
}

TEST(AlignmentPage, SaysWhatIsNotDetermined) {
  test::PictureOfRun run;
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  for (const int i : {AlignmentLayout::kLeverArm, AlignmentLayout::kBoresight + 2, AlignmentLayout::kAccelScale}) {
    run.alignment.covariance.row(i).setZero();
    run.alignment.covariance.col(i).setZero();
    run.alignment.covariance(i, i) = kInfinity;
  }
  run.alignment.undetermined = {"lever arm: it turns about <x> alone"};
  run.alignment.warnings = {"a clock & its jump"};
  const std::string page = alignment_html(run.picture());
  expect_sound(page);
  for (const char* part :
       {"lever arm: it turns about &lt;x&gt; alone", "a clock &amp; its jump",
        "lever arm x [mm]</th><td class=\"number\">not determined", "lever arm y [mm]</th><td class=\"number\">0.00",
        "boresight heading [deg]</th><td class=\"number\">not determined",
        "accel scale x [ppm]</th><td class=\"number\">not determined"}) {
    EXPECT_TRUE(contains(page, part)) << part;
  }
}

TEST(AlignmentPage, DoesWithLogsOnOtherClocksAndWithLittleData) {
  test::PictureOfRun run({.rest = 10, .run = 30}, 5000);
  std::string page = alignment_html(run.picture());
  expect_sound(page);
  EXPECT_TRUE(contains(page, "reading of either clock, after its own first sample"));
  run.alignment.local.clear();
  run.alignment.correlation = {};
  std::fill(run.aligned.usable.begin(), run.aligned.usable.end(), std::uint8_t{0});
  page = alignment_html(run.picture());
  expect_sound(page);
  EXPECT_TRUE(contains(page, "There is nothing to show."));
}

TEST(AlignmentFigures, StandAloneUnderTheirNames) {
  const test::PictureOfRun run;
  const auto figures = alignment_figures(run.picture());
  std::set<std::string> names;
  for (const Figure& f : figures) {
    names.insert(f.name);
    EXPECT_EQ(test::not_well_formed(f.svg), "") << f.name;
    EXPECT_EQ(f.svg.rfind("<svg xmlns=\"http://www.w3.org/2000/svg\"", 0), 0U) << f.name;
    EXPECT_EQ(f.name.find_first_not_of("abcdefghijklmnopqrstuvwxyz_"), std::string::npos) << f.name;
  }
  EXPECT_EQ(names.size(), figures.size());
  EXPECT_EQ(figures.size(), 4U + 2 + 8 + 2 + 2);
}

TEST(Svg, LogarithmicAxes) {
  EXPECT_EQ(log_ticks(0.5, 2000), (std::vector<double>{1, 10, 100, 1000}));
  EXPECT_EQ(log_ticks(0.9, 21), (std::vector<double>{1, 2, 5, 10, 20}));
  Plot plot("power", {"f", {}, true}, {"d", {}, true});
  plot.line({0, 1, 10, 100, 1000}, {1, 1e-6, 1e-4, -1, 1}, 0, "line");
  const std::string svg = plot.render();
  EXPECT_EQ(test::not_well_formed(svg), "");
  for (const char* tick : {">10⁻⁶<", ">10⁻⁵<", ">0.001<", ">1<", ">100<", ">1000<"}) {
    EXPECT_TRUE(contains(svg, tick)) << tick;
  }
  for (const char* wrong : {"nan", "inf"}) EXPECT_FALSE(contains(svg, wrong)) << wrong;
  // A decade is as long anywhere, and what is not above 0 breaks the line: M at 1 Hz, L at 10 Hz, M at 1000 Hz.
  const std::size_t path = svg.find("class=\"line\"");
  ASSERT_NE(path, std::string::npos);
  const std::string drawn = svg.substr(svg.find("d=\"", path), 60);
  EXPECT_EQ(std::count(drawn.begin(), drawn.end(), 'M'), 2);
  EXPECT_EQ(std::count(drawn.begin(), drawn.end(), 'L'), 1);
}

}  // namespace
}  // namespace piste
