#pragma once
/// Configuration files: YAML in which every number has its unit, and in which a key that nobody reads is an error.
///
/// A file may build on another: with `base: other.yaml` at its top, it starts from the keys of that file and replaces
/// or adds its own. Maps are merged key by key; scalars and lists are replaced as a whole. A base may have a base.
/// Every value remembers the file in which it stands: errors name that file, and relative paths start from its folder.
///
/// Every error is a ConfigError `FILE:LINE: what is wrong, and what would be right`.

#include <filesystem>
#include <functional>
#include <initializer_list>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "piste/io/number_columns.h"
#include "piste/math/so3.h"
#include "piste/math/units.h"

namespace piste {

/// A key that a reader asked a configuration for.
struct KeyUse {
  std::string key;       ///< with the maps that it is in, such as `imu.clock.offset`; those of a list count as one
  std::string takes;     ///< the values that it takes, such as "a time, such as `60 s`"
  std::string fallback;  ///< the value if the key is missing; empty if the reader has none
  bool optional = false;
};

/// What errors call a key instead of `FILE:LINE`, by its path, such as `imu.sensor` or `gnss[0].file`; the whole has an
/// empty path.
using KeyNames = std::function<std::string(const std::string& path)>;

/// One map of a configuration file. A copy refers to the same map. Read all keys, and then call `finish()` on the
/// outermost map: it throws if there is a key that was not read.
class Config {
 public:
  /// Reads a file. Throws ConfigError if the file or its base is missing, is not YAML, repeats a key, or builds on
  /// itself.
  static Config load(const std::filesystem::path& file);
  /// The same from text. Errors name `file`, and relative paths start from its folder. A log's `file` may be the name
  /// of one of `tables`. With `names`, errors name keys by these: for text that was made of a program's arguments.
  static Config parse(const std::string& text, const std::filesystem::path& file, NamedColumns tables = {},
                      KeyNames names = {});

  /// Whether the key is there. This does not count as reading it.
  bool has(std::string_view key) const;
  /// Whether the key is there and has a map. This does not count as reading it.
  bool is_map(std::string_view key) const;
  /// Whether the key is there and has a single value, not a map or a list.
  bool is_scalar(std::string_view key) const;
  /// The names of all keys that are there. This does not count as reading them.
  std::vector<std::string> names() const;

  /// The map at `key`; the same, or nothing if the key is missing; the maps of a list at `key`. A single map counts as
  /// a list of one, and a missing key as an empty list.
  Config map(std::string_view key) const;
  std::optional<Config> find_map(std::string_view key) const;
  std::vector<Config> maps(std::string_view key) const;

  /// A quantity with its unit, converted to SI and radians. `fallback` is the value if the key is missing; without it a
  /// missing key is an error.
  double quantity(std::string_view key, const Dimension&, std::optional<double> fallback = {}) const;
  /// The same; a negative value is an error.
  double magnitude(std::string_view key, const Dimension&, std::optional<double> fallback = {}) const;
  Vector3d vector(std::string_view key, const Dimension&, const std::optional<Vector3d>& fallback = {}) const;
  double number(std::string_view key, std::optional<double> fallback = {}) const;
  long integer(std::string_view key, std::optional<long> fallback = {}) const;
  bool flag(std::string_view key, std::optional<bool> fallback = {}) const;
  std::string text(std::string_view key, const std::optional<std::string>& fallback = {}) const;
  /// A list of words, or words separated by spaces, each with a comma behind it or not. Empty if the key is missing.
  std::vector<std::string> words(std::string_view key) const;
  /// A list of pairs such as `[1 s, 2 s]`. A number without unit is taken to be in SI. Empty if the key is missing.
  std::vector<std::pair<double, double>> pairs(std::string_view key, const Dimension&) const;
  /// One such pair.
  std::pair<double, double> pair(std::string_view key, const Dimension&) const;

  /// The value of the named choice that stands at `key`.
  template <class E>
  E choice(std::string_view key, std::initializer_list<std::pair<std::string_view, E>> choices,
           std::optional<E> fallback = {}) const {
    return choice<E>(key, std::span(choices.begin(), choices.size()), fallback);
  }
  template <class E>
  E choice(std::string_view key, std::span<const std::pair<std::string_view, E>> choices,
           std::optional<E> fallback = {}) const {
    std::vector<std::string_view> names;
    std::string_view otherwise;
    for (const auto& c : choices) {
      names.push_back(c.first);
      if (fallback && otherwise.empty() && c.second == *fallback) otherwise = c.first;
    }
    know_choice(key, names, otherwise);
    if (fallback && !has(key)) return *fallback;
    return (choices.begin() + static_cast<std::ptrdiff_t>(index_of_choice(key, names)))->second;
  }

  /// The sensor axes that point forward, right and down, such as `+x -y -z`, as the matrix R_bs that turns components
  /// along the sensor axes into b. Identity if the key is missing. Axes that are not a right-handed frame are an error.
  Matrix3d axes(std::string_view key) const;

  /// A path, relative to the folder of the file in which it stands. `existing_file` throws if it is not a file.
  std::filesystem::path path(std::string_view key) const;
  std::filesystem::path existing_file(std::string_view key) const;

  /// The table in memory whose name stands at the key; null if it is none.
  const NumberColumns* table(std::string_view key) const;

  /// `FILE:LINE` of the key, or of this map if there is no key; or its name, where keys have names (parse()).
  std::string where(std::string_view key = {}) const;
  /// Throws ConfigError with that place.
  [[noreturn]] void fail(std::string_view key, const std::string& what) const;

  /// Throws ConfigError if a key in this map, or in a map below it, was not read.
  void finish() const;

  /// Every key that was asked for so far, here and in the maps below that are there: map by map, in the order in which
  /// they were asked for. The page of all keys is made of it (tests/law/keys.cpp).
  std::vector<KeyUse> asked() const;

  /// The text of the file, without its base.
  const std::string& source() const;
  const std::filesystem::path& file() const;

 private:
  struct Document;
  struct Node;
  Config(std::shared_ptr<const Document> document, Node* node) : document_(std::move(document)), node_(node) {}

  // `above` are the files that build on this one.
  static Config over_base(const std::string& text, const std::filesystem::path& file,
                          std::vector<std::filesystem::path> above, NamedColumns tables = {}, KeyNames names = {});
  const Node* find(std::string_view key) const;
  // Remember what is expected at a key.
  void know(std::string_view key, std::string_view takes, std::string_view fallback = {}) const;
  void know_choice(std::string_view key, const std::vector<std::string_view>& names, std::string_view fallback) const;
  const Node& require(std::string_view key) const;
  const std::string& scalar(std::string_view key) const;
  std::size_t index_of_choice(std::string_view key, const std::vector<std::string_view>& names) const;
  std::pair<double, double> pair_of(std::string_view key, const Node&, const Dimension&) const;
  void finish(const Node&) const;
  template <class F>
  auto checked(std::string_view key, F&& parse) const;

  std::shared_ptr<const Document> document_;
  Node* node_;  // in document_
};

/// `text` as a quoted YAML value, which reads back unchanged.
std::string yaml_text(std::string_view text);

/// The word of `known` whose spelling is nearest to `word`, or nothing if none is near. For error messages.
std::optional<std::string> nearest_spelling(std::string_view word, const std::vector<std::string>& known);

}  // namespace piste
