#pragma once
/// Draws a table of numbers between −1 and 1 as colours. The SVG works as a file and inside a page, on light and on
/// dark ground.

#include <string>
#include <vector>

namespace piste {

/// A table of colours: blue above 0 and orange below, paler near 0, with the number printed in each cell. Colour-blind
/// readers can distinguish the colours. A value that is not finite is an empty cell.
struct HeatMap {
  std::string title;                                 ///< shown above
  std::string description = {};                      ///< for screen readers; empty = the title
  std::vector<std::string> rows = {}, columns = {};  ///< their names
  std::vector<std::vector<double>> values = {};      ///< row by row. @pre as many as there are rows and columns

  /// The `<svg>` element.
  std::string render() const;
};

}  // namespace piste
