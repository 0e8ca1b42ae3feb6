#pragma once
/// A picture with its name and caption.

#include <memory>
#include <string>

namespace piste {

class Plot;

/// One picture: its file name without extension, a complete `<svg>` element, and a sentence that says what it shows.
struct Figure {
  std::string name, svg, caption;
  std::shared_ptr<const Plot> plot = {};  ///< the curves, by which a page draws it anew at each zoom; null: it has none
};

}  // namespace piste
