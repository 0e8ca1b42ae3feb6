#pragma once
/// Where a writer puts its text, so that a long file never stands in memory as a whole.

#include <functional>
#include <string_view>

namespace piste {

/// Takes the pieces of a text in their order.
using TextSink = std::function<void(std::string_view)>;

}  // namespace piste
