#pragma once
/// Draws y over x. The SVG works as a file and inside a page, on light and on dark ground.

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "piste/plot/figure.h"

namespace piste {

/// Ascending round values (1, 2 or 5 times a power of ten apart) inside [low, high], about `wanted` of them.
/// @pre low < high, wanted ≥ 1.
std::vector<double> nice_ticks(double low, double high, int wanted);

/// Ticks of a logarithmic axis inside [low, high], ascending. They are the powers of ten if there are at least three.
/// Else they are 1, 2 and 5 times powers of ten if these are at least three, or else nice_ticks.
/// @pre 0 < low < high.
std::vector<double> log_ticks(double low, double high);

/// One picture. Colours are numbers, 0 to 6, of a palette that colour-blind readers can distinguish, or svg::kInk. A
/// point with a coordinate that is not finite interrupts a line, and is left out of other series.
class Plot {
 public:
  struct Axis {
    std::string label;               ///< with its unit: "east [m]"
    std::vector<double> ticks = {};  ///< empty = chosen by the picture
    bool log = false;                ///< logarithmic; values that are not above 0 are treated as not finite
    /// Names instead of numbers, at 0, 1, 2, …, from the left or from the top.
    std::vector<std::string> names = {};
  };

  /// `title` is shown above the picture. `description` is for screen readers, and may say more.
  Plot(std::string title, Axis x, Axis y, std::string description = {});

  enum class Stroke { kSolid, kDashed, kDotted };

  /// A series named in the legend by `label`, which may be empty. @pre x and y are equally long.
  void line(std::vector<double> x, std::vector<double> y, int colour, std::string label,
            Stroke stroke = Stroke::kSolid);
  void points(std::vector<double> x, std::vector<double> y, int colour, std::string label);
  enum class Along { kX, kY };
  /// Points, each with a whisker from `low` to `high`. A whisker whose ends are not finite is left out, but its point
  /// is drawn.
  void bars(std::vector<double> x, std::vector<double> y, std::vector<double> low, std::vector<double> high, int colour,
            std::string label, Along along = Along::kY);
  /// The area between `low` and `high`.
  void band(std::vector<double> x, std::vector<double> low, std::vector<double> high, int colour, std::string label);
  /// A stretch of x, over the whole height.
  void shade(double from, double to, int colour, std::string label);
  /// One large point with its name next to it.
  void mark(double x, double y, int colour, std::string name);

  /// Sets the limits of an axis. What lies beyond them is cut off. @pre low < high
  void limit_x(double low, double high) { x_limit_ = {{low, high}}; }
  void limit_y(double low, double high) { y_limit_ = {{low, high}}; }
  /// Makes one unit of x as long as one of y, for maps.
  void equal_scale() { equal_scale_ = true; }
  /// Sets the size in CSS pixels. The default is 760 × 480.
  static constexpr int kPageWidth = 980;  ///< of a picture that fills a page
  void size(int width, int height);

  /// The `<svg>` element. Of long lines it has the extremes (thin.h).
  std::string render() const;

  enum class Kind { kLine, kPoints, kBarsAlongX, kBarsAlongY, kBand, kShade };
  struct Series {
    Kind kind;
    std::vector<double> x, y, low, high;
    int colour;
    std::string label;
    Stroke stroke = Stroke::kSolid;
  };
  struct Mark {
    double x, y;
    int colour;
    std::string name;
  };
  /// What it was given, for what else draws it.
  const std::string& title() const { return title_; }
  const Axis& x() const { return x_; }
  const Axis& y() const { return y_; }
  const std::optional<std::array<double, 2>>& x_limit() const { return x_limit_; }
  const std::optional<std::array<double, 2>>& y_limit() const { return y_limit_; }
  bool is_map() const { return equal_scale_; }
  /// Where a point is in the picture [px]: to the right and downwards from its upper left corner.
  std::array<double, 2> pixel(double x, double y) const;
  const std::vector<Series>& series() const { return series_; }
  const std::vector<Mark>& marks() const { return marks_; }

 private:
  struct Range;
  struct Frame;
  Frame frame() const;
  std::string axes(const Frame& frame) const;
  std::string legend() const;
  std::vector<std::array<double, 2>> legend_places() const;
  static std::string draw(const Series& series, const Frame& frame);
  static std::string draw(const Mark& mark, bool below, const Frame& frame);

  std::string title_, description_;
  Axis x_, y_;
  int width_ = 760, height_ = 480;
  bool equal_scale_ = false;
  std::optional<std::array<double, 2>> x_limit_, y_limit_;
  std::vector<Series> series_;
  std::vector<Mark> marks_;
};

/// A plot as a figure.
Figure as_figure(std::string name, Plot plot, std::string caption);

}  // namespace piste
