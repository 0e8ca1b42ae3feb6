#pragma once
/// Joins lists.

#include <iterator>
#include <string>
#include <vector>

#include "piste/search/inspect.h"

namespace piste {

/// Moves the elements of `more` to the end of `to`.
template <class List>
void append(List& to, List&& more) {
  to.insert(to.end(), std::make_move_iterator(more.begin()), std::make_move_iterator(more.end()));
}

/// Files as logs to be inspected.
inline std::vector<LogSource> sources_of(const std::vector<std::string>& files) {
  std::vector<LogSource> sources;
  sources.reserve(files.size());
  for (const std::string& file : files) sources.push_back({.file = file});
  return sources;
}

}  // namespace piste
