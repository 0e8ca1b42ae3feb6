#pragma once
/// The size of a statistical test: small on each change, large on request.

#include <cstdlib>
#include <string_view>

namespace piste::test {

/// Whether the environment has PISTE_THOROUGH=1, as set by scripts/nightly.
inline bool thorough() {
  const char* value = std::getenv("PISTE_THOROUGH");
  return value != nullptr && std::string_view(value) == "1";
}

/// The number of seeds of a statistical test, which are 1, 2, 3 and so on: `usual` on each change, else `many`.
inline int seeds(int usual, int many) { return thorough() ? many : usual; }

}  // namespace piste::test
