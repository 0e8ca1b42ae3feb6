#pragma once
/// A picture with its words.

#include <string>

namespace piste {

/// One picture: the stem of its file name, the `<svg>` element that stands alone, and what it shows, in a sentence.
struct Figure {
  std::string name, svg, caption;
};

}  // namespace piste
