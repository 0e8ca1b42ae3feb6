#pragma once
/// Functions that must link, under the headers that export them.

#include <algorithm>

namespace consumer {

struct Exported {
  const char* header;
  const void* function;
};

template <class Function>
const void* address(Function* function) {
  return reinterpret_cast<const void*>(function);
}

inline bool all_link(const Exported* begin, const Exported* end) {
  return std::none_of(begin, end, [](const Exported& e) { return e.function == nullptr; });
}

}  // namespace consumer
