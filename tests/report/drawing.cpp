// Figures become charts whose tables hold what the figure was given, and stay pictures where they are no curves.

#include "report/drawing.h"

#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <vector>

#include "report/packed_columns.h"
#include "support/text_file.h"

namespace piste {
namespace {

using test::contains;

/// What a page's scripts are given.
YAML::Node data_of(const page::Drawing& drawing) {
  const std::string scripts = drawing.scripts();
  const std::size_t from = scripts.find('{'), to = scripts.find("</script>");
  return YAML::Load(scripts.substr(from, to - from));  // JSON is YAML
}

std::vector<double> column(const YAML::Node& data, const std::string& table, const std::string& name) {
  return test::columns_of(data["tables"][table])[name];
}

TEST(Drawing, HoldsWhatTheFigureWasGiven) {
  Plot plot("Power", {"frequency [Hz]", {}, true}, {"density [(m/s²)²/Hz]", {}, true});
  const std::vector<double> x{0.1, 1, 10, 100}, y{4e-9, 3e-3, 0, 2};
  plot.band(x, {1e-9, 1e-3, 1e-3, 1}, {8e-9, 5e-3, 1e-2, 3}, 2, "");
  plot.line(x, y, 2, "body");
  plot.line({100, 1}, {1, 5}, 2, "body", Plot::Stroke::kDashed);
  plot.mark(10, 1, 3, "a peak");
  plot.limit_y(1e-9, 4);
  page::Drawing drawing;
  const std::string body = drawing.add({as_figure("power", plot, "A <caption>.")});
  EXPECT_TRUE(contains(body, "data-chart=\"power\"")) << body;
  EXPECT_TRUE(contains(body, "A &lt;caption&gt;.")) << body;
  EXPECT_FALSE(contains(body, "<svg"));
  const YAML::Node data = data_of(drawing), chart = data["charts"][0];
  EXPECT_EQ(chart["unit"].as<std::string>(), "(m/s²)²/Hz");
  EXPECT_EQ(chart["limits"][1].as<double>(), 4);
  ASSERT_EQ(chart["curves"].size(), 3U) << "the band is that of its line";
  EXPECT_EQ(chart["curves"][1]["label"].as<std::string>(), "body 2") << "names are different";
  EXPECT_EQ(chart["curves"][1]["stroke"].as<std::string>(), "dashed");
  EXPECT_EQ(chart["curves"][2]["stroke"].as<std::string>(), "dots");
  const std::vector<double> places = column(data, "power/0", "x"), values = column(data, "power/0", "value"),
                            low = column(data, "power/0", "value_least");
  ASSERT_EQ(values.size(), x.size());
  for (std::size_t i = 0; i < x.size(); ++i) {
    EXPECT_NEAR(places[i], std::log10(x[i]), 1e-8);
    if (y[i] > 0) {
      EXPECT_NEAR(values[i], y[i], 1e-4 * y[i]);
    } else {
      EXPECT_TRUE(std::isnan(values[i])) << "a logarithm has no place for it";
    }
  }
  EXPECT_NEAR(low[3], 1, 1e-4);
  EXPECT_EQ(column(data, "power/1", "value")[0], 5) << "in the order of the axis";
  const YAML::Node axis = data["axes"][chart["axis"].as<std::string>()];
  EXPECT_EQ(axis["label"].as<std::string>(), "frequency");
  EXPECT_EQ(axis["unit"].as<std::string>(), "Hz");
  EXPECT_LT(axis["start"].as<double>(), places.front()) << "no row is outside by rounding";
  EXPECT_GT(axis["end"].as<double>(), places.back());
}

TEST(Drawing, SharesAnAxisOfOneRange) {
  const auto of = [](const char* name, double end) {
    Plot plot(name, {"time [s]"}, {"height [m]"});
    plot.line({0, 1, end}, {1, 2, 3}, 0, "");
    plot.shade(0, 1, 5, "at rest");
    return as_figure(name, plot, "");
  };
  page::Drawing drawing;
  drawing.add({of("a", 2), of("b", 2), of("c", 3)});
  const YAML::Node charts = data_of(drawing)["charts"];
  EXPECT_EQ(charts[0]["axis"].as<std::string>(), charts[1]["axis"].as<std::string>());
  EXPECT_NE(charts[0]["axis"].as<std::string>(), charts[2]["axis"].as<std::string>());
  EXPECT_EQ(data_of(drawing)["axes"][charts[0]["axis"].as<std::string>()]["shades"][0]["kind"].as<std::string>(),
            "rest");
}

TEST(Drawing, LeavesMapsAndNamesAsPictures) {
  Plot map("map", {"east [m]"}, {"north [m]"}), names("names", {"", {}, false, {"a", "b"}}, {"y"});
  map.equal_scale();
  map.line({0, 1}, {0, 1}, 0, "");
  names.points({0, 1}, {0, 1}, 0, "");
  page::Drawing drawing;
  const std::string body =
      drawing.add({as_figure("map", map, ""), as_figure("names", names, ""), {"svg", "<svg/>", "no plot"}});
  EXPECT_FALSE(contains(body, "data-chart"));
  EXPECT_TRUE(contains(body, "no plot"));
  EXPECT_EQ(drawing.head() + drawing.style() + drawing.scripts(), "") << "a page without charts has no scripts";
}

TEST(Drawing, LongCurvesKeepTheirExtremes) {
  constexpr std::size_t kRows = 200'000;
  std::vector<double> x(kRows), y(kRows, 1);
  for (std::size_t i = 0; i < kRows; ++i) x[i] = 0.01 * static_cast<double>(i);
  y[123'456] = 7;
  Plot plot("long", {"time [s]"}, {"rate [deg/s]"});
  plot.line(x, y, 0, "");
  page::Drawing drawing;
  drawing.add({as_figure("long", plot, "")});
  const std::vector<double> most = column(data_of(drawing), "long/0", "value_most");
  EXPECT_LT(most.size(), 15'000U);
  EXPECT_NEAR(*std::max_element(most.begin(), most.end()), 7, 1e-3);
}

}  // namespace
}  // namespace piste
