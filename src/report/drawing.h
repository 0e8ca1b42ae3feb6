#pragma once
/// The figures of a page as charts, which zoom and show their values.

#include <string>
#include <vector>

#include "piste/plot/figure.h"
#include "plot/svg.h"
#include "report/page_data.h"

namespace piste::page {

/// Collects the figures of a page. Those that are curves over numbers become charts; charts whose axis has one label
/// and one range share window and cursor. Maps, and figures with names on an axis, stay pictures, and so do all where
/// the libraries are missing.
///
///     Drawing drawing;
///     const std::string body = drawing.add({as_figure("norms", plot, "Norms of the rates.")});
///     page::render({…, .head = drawing.head(), …, .style = drawing.style(), .scripts = drawing.scripts()});
class Drawing {
 public:
  /// A line on a map: where it is at each x of an axis.
  struct Path {
    std::vector<double> x, east, north;
    int colour = 0;
  };

  /// The places of the figures, with their captions.
  std::string add(const std::vector<Figure>& figures);
  /// The place of a map on which the cursor of the axis of `over` is shown on each path, and that sets it.
  /// @pre the figure of `over` was added
  std::string add_map(const Figure& map, const Plot& over, const std::vector<Path>& paths);
  /// Of a page: what stands above all charts, styles and scripts; empty without any chart.
  std::string head() const;
  std::string style() const;
  std::string scripts() const;

 private:
  std::string chart_of(const Figure& figure);
  std::string axis_of(const Plot& plot);
  Data data_;
};

}  // namespace piste::page
