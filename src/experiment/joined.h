#pragma once
/// Lists that are put together.

#include <iterator>

namespace piste {

/// Moves the elements of `more` to the end of `to`.
template <class List>
void append(List& to, List&& more) {
  to.insert(to.end(), std::make_move_iterator(more.begin()), std::make_move_iterator(more.end()));
}

}  // namespace piste
