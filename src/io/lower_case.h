#pragma once
/// Texts of logs whose letters may be large or small.

#include <algorithm>
#include <cctype>
#include <string>
#include <string_view>

namespace piste {

/// The text in small letters, of ASCII alone.
inline std::string lower_case(std::string_view text) {
  std::string lower(text);
  std::transform(lower.begin(), lower.end(), lower.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return lower;
}

}  // namespace piste
