// Pictures of named things, with whiskers.

#include "plot/svg.h"

#include <gtest/gtest.h>

#include <limits>
#include <string>

#include "plot/markup.h"
#include "report/well_formed.h"
#include "support/text_file.h"

namespace piste {
namespace {

using test::contains;

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

/// Of the number that follows `name` in the last tag before `text`.
double attribute(const std::string& svg, const std::string& name, const std::string& text) {
  const std::size_t tag = svg.rfind('<', svg.find(">" + text + "<"));
  const std::size_t at = svg.find(" " + name + "=\"", tag);
  return std::stod(svg.substr(at + name.size() + 3));
}

TEST(Svg, NamesGoFromTheLeftAndFromTheTop) {
  Plot plot("names", {"", {}, false, {"left", "right"}}, {"", {}, false, {"a very long <name>", "below"}});
  plot.points({0, 1}, {0, 1}, 0, "");
  const std::string svg = plot.render();
  EXPECT_EQ(test::not_well_formed(svg), "");
  EXPECT_LT(attribute(svg, "x", "left"), attribute(svg, "x", "right"));
  EXPECT_LT(attribute(svg, "y", "a very long &lt;name&gt;"), attribute(svg, "y", "below"));
  // The longest name, that ends there, has its room: 18 letters of some 7 pixels.
  EXPECT_GT(attribute(svg, "x", "below"), 18 * 7);
  EXPECT_FALSE(contains(svg, ">0.5<"));
}

TEST(Svg, BarsHaveWhiskersAsFarAsTheyAreKnown) {
  const auto draw = [](Plot::Along along, double low, double high) {
    Plot plot("bars", {"x"}, {"y"});
    plot.limit_x(0, 2);
    plot.limit_y(0, 2);
    plot.bars({1}, {1}, {low}, {high}, 3, "bar", along);
    const std::string svg = plot.render();
    EXPECT_EQ(test::not_well_formed(svg), "");
    EXPECT_FALSE(contains(svg, "nan"));
    return svg;
  };
  // The middle of 760 × 480 less its margins and a row of the legend: (409, 223).
  const std::string upright = draw(Plot::Along::kY, 0, 2);
  EXPECT_TRUE(contains(upright, "M409.0 406.0V40.0")) << upright;
  EXPECT_TRUE(contains(upright, "M409.0 223.0h0"));
  EXPECT_TRUE(contains(draw(Plot::Along::kX, 0, 2), "M76.0 223.0H742.0"));
  const std::string open = draw(Plot::Along::kY, kNaN, 2);
  EXPECT_FALSE(contains(open, "V40.0\""));
  EXPECT_TRUE(contains(open, "M409.0 223.0h0")) << "the point stays";
  EXPECT_TRUE(contains(open, ">bar</text>"));
}

TEST(Svg, WhiskersAreInThePicture) {
  Plot plot("bars", {"x"}, {"y"});
  plot.bars({0, 1}, {0, 0}, {-8, -1}, {8, 1}, 0, "");
  const std::string svg = plot.render();
  EXPECT_TRUE(contains(svg, ">−8<")) << "along y";
  EXPECT_TRUE(contains(svg, ">0.8<")) << "and x is as long as the points need";
}

TEST(Svg, LogarithmicTicksOfLessThanADecade) {
  EXPECT_EQ(log_ticks(1.5, 3.5), (std::vector<double>{1.5, 2, 2.5, 3, 3.5}));
  Plot plot("", {"x"}, {"y", {}, true});
  plot.line({0, 1}, {1.2e-6, 1.8e-6}, 0, "");
  EXPECT_TRUE(contains(plot.render(), ">1.4·10⁻⁶<"));
}

TEST(Markup, DecimalsHaveARealMinusSign) {
  EXPECT_EQ(decimal(-0.25, 3), "−0.250");
  EXPECT_EQ(decimal(12.345, 1), "12.3");
  EXPECT_EQ(decimal(-0.0004, 3), "0.000");
}

}  // namespace
}  // namespace piste
