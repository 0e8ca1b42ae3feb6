#pragma once
/// A table of numbers between −1 and 1 as colours, as SVG that stands alone or inside a page, in light and in dark.

#include <string>
#include <vector>

namespace piste {

/// Blue above 0 and orange below, the paler the nearer to 0, with the number printed in each cell: colour-blind readers
/// can tell them apart. What is not finite is an empty cell.
struct HeatMap {
  std::string title;                                 ///< shown above
  std::string description = {};                      ///< read aloud by screen readers; empty = the title
  std::vector<std::string> rows = {}, columns = {};  ///< their names
  std::vector<std::vector<double>> values = {};      ///< row by row. @pre as many as there are rows and columns

  /// The `<svg>` element.
  std::string render() const;
};

}  // namespace piste
