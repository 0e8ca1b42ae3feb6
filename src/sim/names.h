#pragma once
/// Names in scenario files: reads new ones, and finds existing ones.

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "piste/io/config.h"

namespace piste {

/// Reads the key `name` and adds it to `names`. It becomes the name of a file or folder, and of a random stream. Throws
/// ConfigError if it cannot be a file name, or is in `names` already.
inline std::string claim_name(std::set<std::string>& names, const Config& config) {
  std::string name = config.text("name");
  if (name.empty() || name.starts_with('-') ||
      name.find_first_not_of("abcdefghijklmnopqrstuvwxyz0123456789_-") != std::string::npos) {
    config.fail("name", fmt::format("`{}` becomes a file name; use small letters, digits, `_` and `-`", name));
  }
  if (!names.insert(name).second) {
    config.fail("name", fmt::format("`{}` is taken; give each a name of its own", name));
  }
  return name;
}

/// Index of the sensor `name` in a list of a scenario. Throws ConfigError at `key` if there is none; the message calls
/// the list's owner `scenario`.
template <class Setup>
std::size_t place_of(const Config& config, std::string_view key, const std::string& name,
                     const std::vector<Setup>& setups, std::string_view scenario = "the scenario") {
  std::vector<std::string> there;
  there.reserve(setups.size());
  for (const Setup& s : setups) there.push_back(s.name);
  const auto place = static_cast<std::size_t>(std::find(there.begin(), there.end(), name) - there.begin());
  if (place == there.size()) {
    const auto near = nearest_spelling(name, there);
    config.fail(key, fmt::format("{} has no `{}`{}; there are: {}", scenario, name,
                                 near ? fmt::format(", perhaps `{}`", *near) : "",
                                 there.empty() ? "none" : fmt::format("{}", fmt::join(there, ", "))));
  }
  return place;
}

}  // namespace piste
