#pragma once
/// The size of a statistical test: small on each change, large on request.

#include <cstdio>
#include <cstdlib>
#include <stdexcept>
#include <string_view>

namespace piste::test {

/// Whether the environment has PISTE_THOROUGH=1, as set by scripts/nightly.
inline bool thorough() {
  const char* value = std::getenv("PISTE_THOROUGH");
  return value != nullptr && std::string_view(value) == "1";
}

/// The number of seeds of a statistical test, which are 1, 2, 3 and so on: `usual` on each change, else `many`.
inline int seeds(int usual, int many) { return thorough() ? many : usual; }

/// The seeds of a property: `first` to `last`.
struct SeedRange {
  int first = 1, last = 1;
  int size() const { return last - first + 1; }
};

/// From 1 to `usual`, or as PISTE_SEEDS=FIRST-LAST has them in the environment: scripts/nightly goes on where it was.
inline SeedRange property_seeds(int usual) {
  SeedRange seeds{1, usual};
  const char* stated = std::getenv("PISTE_SEEDS");
  if (stated != nullptr && std::sscanf(stated, "%d-%d", &seeds.first, &seeds.last) != 2)  // NOLINT: of a fixed form
    throw std::invalid_argument("PISTE_SEEDS wants FIRST-LAST, such as 1-100");
  return seeds;
}

}  // namespace piste::test
