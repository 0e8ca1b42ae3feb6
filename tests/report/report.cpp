// Reports of a made-up run are whole, well-formed, escaped and small enough.

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <fstream>
#include <functional>
#include <limits>

#include "math/geoid.h"
#include "piste/report/html.h"
#include "piste/report/kml.h"
#include "piste/report/tuning_page.h"
#include "plot/markup.h"
#include "plot/svg.h"
#include "plot/thin.h"
#include "report/synthetic_run.h"
#include "report/well_formed.h"

namespace piste {
namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

std::size_t count(const std::string& text, const std::string& what) {
  std::size_t n = 0;
  for (std::size_t at = text.find(what); at != std::string::npos; at = text.find(what, at + 1)) ++n;
  return n;
}

TEST(Thin, KeepsEndsAndExtremes) {
  std::vector<double> flat(10000, 0.0), wave(10000);
  for (std::size_t i = 0; i < wave.size(); ++i) wave[i] = std::sin(0.01 * static_cast<double>(i));
  flat[4321] = 9;
  wave[777] = kNan;
  const std::vector<std::vector<double>> columns{flat, wave};
  const auto rows = thin(columns, 400);
  EXPECT_LE(rows.size(), 402U);
  EXPECT_EQ(rows.front(), 0U);
  EXPECT_EQ(rows.back(), 9999U);
  EXPECT_TRUE(std::binary_search(rows.begin(), rows.end(), 4321U));
  EXPECT_TRUE(std::adjacent_find(rows.begin(), rows.end(), std::greater_equal<>()) == rows.end());
  EXPECT_EQ(thin(columns, 10000).size(), 10000U);
  EXPECT_TRUE(thin({}, 10).empty());
}

TEST(Svg, TicksAreRoundAndInside) {
  EXPECT_EQ(nice_ticks(0, 10, 5), (std::vector<double>{0, 2, 4, 6, 8, 10}));
  const auto ticks = nice_ticks(-0.37, 0.41, 8);
  EXPECT_NEAR(ticks[1] - ticks[0], 0.1, 1e-12);
  EXPECT_GE(ticks.front(), -0.37);
  EXPECT_LE(ticks.back(), 0.41);
}

TEST(Svg, IsWellFormedAndBreaksLinesAtGaps) {
  Plot plot("a < b & \"c\"", {"x [m]"}, {"y [m]"});
  plot.line({0, 1, kNan, 3, 4}, {0, 1, 2, 3, 4}, 0, "line <1>");
  plot.points({0, 1}, {kNan, 3}, 8, "points");
  plot.band({0, 1}, {0, 0}, {1, 2}, -1, "band");
  plot.mark(4, 4, 2, "end");
  const std::string svg = plot.render();
  EXPECT_EQ(test::not_well_formed(svg), "");
  EXPECT_NE(svg.find("a &lt; b &amp; &quot;c&quot;"), std::string::npos);
  EXPECT_EQ(svg.find("nan"), std::string::npos);
  EXPECT_EQ(test::not_well_formed(Plot("empty", {"x"}, {"y"}).render()), "");
}

TEST(Svg, TheCheckCatchesWhatIsWrong) {
  EXPECT_NE(test::not_well_formed("<a><b></a></b>"), "");
  EXPECT_NE(test::not_well_formed("<a>x & y</a>"), "");
  EXPECT_NE(test::not_well_formed("<a>"), "");
}

TEST(Kml, HoldsTheTrackWithItsEnds) {
  const auto run = test::synthetic_run(20);
  const std::string text = kml(run.filtered, "ski & bike", {}, 500);
  EXPECT_EQ(test::not_well_formed(text), "");
  EXPECT_NE(text.find("ski &amp; bike"), std::string::npos);
  EXPECT_EQ(count(text, "<LineString>"), 1U);
  EXPECT_EQ(count(text, "<Point>"), 2U);
  EXPECT_LT(count(text, "\n"), 540U);
  // The run starts at its origin: 0.12 rad east, 0.81 rad north, 1600 m above the ellipsoid.
  const std::string place = fmt::format("{:.3f}", 1600 - geoid_undulation({0.81, 0.12, 1600}));
  EXPECT_NE(text.find("6.875493542,46.409581406," + place), std::string::npos);
  const std::string dated = kml(run.filtered, "ski", 2200, 500);
  EXPECT_EQ(test::not_well_formed(dated), "");
  EXPECT_EQ(count(dated, "<gx:Track>"), 1U);
  EXPECT_EQ(count(dated, "<when>"), count(dated, "<gx:coord>"));
  EXPECT_NE(dated.find("<gx:coord>6.875493542 46.409581406 " + place), std::string::npos);
  EXPECT_EQ(test::not_well_formed(kml(Solution(), "empty")), "");
}

TEST(Html, TellsEverythingInOneSmallFile) {
  const auto run = test::synthetic_run(100);
  ReplayReport report{"Ski run",     "0.1.0", "imu: {file: <a>}\n</pre></script>", &run.log, &run.filtered,
                      &run.smoothed, {}};
  report.outages = {{345060, 345075}};
  report.warnings = {"one & two"};
  const std::string page = html_report(report);
  EXPECT_LT(page.size(), 5'000'000U);
  for (const char* part :
       {"Dygraph", "Leaflet", "id=\"plan\"", "Heading, 1σ rms", "Gyro bias", "Boresight", "gnss[0].position: NIS",
        "withheld", "rejected", "imu: {file: &lt;a&gt;}", "piste 0.1.0", "\"smoothed\": {", "<li>one &amp; two</li>"}) {
    EXPECT_NE(page.find(part), std::string::npos) << part;
  }
  for (const char* wrong : {"src=\"http", "<link", "href=\"http", "@import", "url(", ":nan", ",nan", "inf,"}) {
    EXPECT_EQ(page.find(wrong), std::string::npos) << wrong;
  }
  EXPECT_EQ(count(page, "<script"), count(page, "</script>"));
  // PISTE_SHOW=FILE keeps the page to be looked at.
  if (const char* file = std::getenv("PISTE_SHOW")) std::ofstream(file) << page;
}

// The page of a run with this verdict.
std::string page_of(const Verdict& verdict) {
  const auto run = test::synthetic_run(20);
  return html_report({.title = "run",
                      .version = "1",
                      .config_text = "",
                      .log = &run.log,
                      .filtered = &run.filtered,
                      .verdict = &verdict});
}

TEST(Html, AnUncertainVerdictNamesWhatDecided) {
  Verdict verdict;
  verdict.consistent = false;
  verdict.factor = 1.3;
  verdict.sources = {
      {.name = "gnss[0].position", .fixes = 100, .nis = 1.68, .holds = false, .reasons = {"too <large>"}}};
  verdict.jumps = {{"gyro_scale y", -19.4}};
  const std::string page = page_of(verdict);
  for (const char* part :
       {"Do not rely on the stated accuracy: sigmas are too small by 1.3", "gnss[0].position: too &lt;large&gt;",
        "gyro_scale y is 19.4 sigmas from its prior; up to 4.5 may be"}) {
    EXPECT_NE(page.find(part), std::string::npos) << part;
  }
}

TEST(Html, SigmasThatAreTooLargeAreNoReasonToDistrust) {
  Verdict verdict;
  verdict.consistent = false;
  verdict.factor = 0.7;
  const std::string page = page_of(verdict);
  EXPECT_NE(page.find("The accuracy is better than stated, judged by the measurements: sigmas are too large by "
                      "1.4."),
            std::string::npos);
  EXPECT_EQ(page.find("Do not rely"), std::string::npos);
  EXPECT_NE(page.find("\u00a0s</"), std::string::npos);
}

TEST(TuningPage, HasEveryNumberWithItsInterval) {
  Tuning tuning;
  tuning.numbers = {{"gyro.noise", "deg/s/sqrt(Hz)", 0.05, 0.051, 0.0494, 0.0524, true, 2.302585},
                    {"gnss[0].sigma_scale", "", 1, 1.3, 0.4, 4, false}};
  tuning.likelihood = 12.5;
  tuning.rows = 321;
  tuning.nis = {{"gnss[0].position", 100, 1.02, 0.03}};
  const std::string page = tuning_page(tuning, "run <1>", "name: <x>", "1");
  for (const char* part : {"run &lt;1&gt;", "<td class=\"number\">0.0494 to 0.0524</td>", "1 of 2", "12.5", "321 rows",
                           "1.02 ± 0.03", "<td class=\"number\">0.000548 to 4.56</td>", "name: &lt;x&gt;",
                           "not determined by the data", "<b>Figure 1.</b>"}) {
    EXPECT_NE(page.find(part), std::string::npos) << part;
  }
  EXPECT_NE(tuning_page({}, "", "", "").find("</html>"), std::string::npos);
}

TEST(Html, DoesWithoutSmootherAndWithoutAnyEpoch) {
  const Log log;
  const Solution empty{StateLayout(), World()};
  const std::string page = html_report({"nothing", "0.1.0", "", &log, &empty});
  EXPECT_EQ(page.find("\"smoothed\": {"), std::string::npos);
  EXPECT_NE(page.find("</html>"), std::string::npos);
}

}  // namespace
}  // namespace piste
