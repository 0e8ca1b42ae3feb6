#pragma once
/// Builds JSON text. The values of objects and arrays are passed as JSON text.

#include <fmt/format.h>

#include <cmath>
#include <iterator>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace piste::json {

/// A number, or null if it is not finite.
inline std::string number(double value, int digits = 10) {
  return std::isfinite(value) ? fmt::format("{:.{}g}", value, digits) : "null";
}

inline std::string boolean(bool value) { return value ? "true" : "false"; }

/// A string. It is safe inside a <script> element.
std::string string(std::string_view text);

std::string array(const std::vector<std::string>& items);

/// An array of strings.
std::string strings(const std::vector<std::string>& texts);

/// An array of numbers.
template <class Range>
std::string numbers(const Range& values, int digits = 10) {
  std::vector<std::string> items;
  items.reserve(static_cast<std::size_t>(std::size(values)));
  for (const double value : values) items.push_back(number(value, digits));
  return array(items);
}

using Members = std::vector<std::pair<std::string, std::string>>;

/// An object on one line.
std::string object(const Members& members);
/// An object with one line for each member, at the indentation of `depth`.
std::string object(const Members& members, int depth);

}  // namespace piste::json
