#pragma once
/// A picture with its name and caption.

#include <string>

namespace piste {

/// One picture: its file name without extension, a complete `<svg>` element, and a sentence that says what it shows.
struct Figure {
  std::string name, svg, caption;
};

}  // namespace piste
