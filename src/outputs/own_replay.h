#pragma once
/// The comment by which `inspect` warns in a configuration that it writes.

#include <string_view>

namespace piste {

/// Its beginning, on the configuration's first line.
inline constexpr std::string_view kOwnReplaySays = "# Its own replay says: ";

}  // namespace piste
