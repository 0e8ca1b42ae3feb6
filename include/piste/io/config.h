#pragma once
/// Configuration files: YAML whose values carry their unit, and whose every key is read or refused.
///
/// A file may build on another: `base: other.yaml` at its top takes that file's map and lays this file's over it, maps
/// key by key, scalars and lists whole. A base may have a base. Every value keeps its own file: errors name it, and
/// relative paths start from its folder.
///
/// Every error is a ConfigError `FILE:LINE: what is wrong, and what would be right`.

#include <filesystem>
#include <initializer_list>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "piste/math/so3.h"
#include "piste/math/units.h"

namespace piste {

/// One map of a configuration file. A copy refers to the same map. Reading a key makes it a known one;
/// `finish()` on the outermost map refuses those that nobody read.
class Config {
 public:
  /// Throws ConfigError where the file or its base is missing, is no YAML, repeats a key, or builds on itself.
  static Config load(const std::filesystem::path& file);
  /// The same from text; `file` is what errors name, and its folder is where relative paths start.
  static Config parse(const std::string& text, const std::filesystem::path& file);

  /// Whether the key is there; it counts as known, not as read.
  bool has(std::string_view key) const;
  /// Whether it is there and holds one value, neither a map nor a list.
  bool is_scalar(std::string_view key) const;

  /// The map at `key`, and the maps of a list at `key` (one map counts as a list of one, none as empty).
  Config map(std::string_view key) const;
  std::optional<Config> find_map(std::string_view key) const;
  std::vector<Config> maps(std::string_view key) const;

  /// A quantity with its unit, in SI and radians. Without `fallback` the key must be there.
  double quantity(std::string_view key, const Dimension&, std::optional<double> fallback = {}) const;
  /// The same, refused below zero.
  double magnitude(std::string_view key, const Dimension&, std::optional<double> fallback = {}) const;
  Vector3d vector(std::string_view key, const Dimension&, const std::optional<Vector3d>& fallback = {}) const;
  double number(std::string_view key, std::optional<double> fallback = {}) const;
  long integer(std::string_view key, std::optional<long> fallback = {}) const;
  bool flag(std::string_view key, std::optional<bool> fallback = {}) const;
  std::string text(std::string_view key, const std::optional<std::string>& fallback = {}) const;
  /// A list of words, or words apart by spaces; none where the key is absent.
  std::vector<std::string> words(std::string_view key) const;
  /// A list of pairs `[1 s, 2 s]`; a number without unit is taken in SI. None where the key is absent.
  std::vector<std::pair<double, double>> pairs(std::string_view key, const Dimension&) const;
  /// One pair `[1 s, 2 s]`, as above.
  std::pair<double, double> pair(std::string_view key, const Dimension&) const;

  /// One of the named choices.
  template <class E>
  E choice(std::string_view key, std::initializer_list<std::pair<std::string_view, E>> choices,
           std::optional<E> fallback = {}) const {
    return choice<E>(key, std::span(choices.begin(), choices.size()), fallback);
  }
  template <class E>
  E choice(std::string_view key, std::span<const std::pair<std::string_view, E>> choices,
           std::optional<E> fallback = {}) const {
    if (fallback && !has(key)) return *fallback;
    std::vector<std::string_view> names;
    for (const auto& c : choices) names.push_back(c.first);
    return (choices.begin() + static_cast<std::ptrdiff_t>(index_of_choice(key, names)))->second;
  }

  /// Sensor axes that point forward, right and down, such as `+x -y -z`, as R_bs: sensor components into b.
  /// Identity where the key is absent; refused where the three are not a right-handed frame.
  Matrix3d axes(std::string_view key) const;

  /// A path, relative to the folder of the file in which it stands. `existing_file` refuses one that is no file.
  std::filesystem::path path(std::string_view key) const;
  std::filesystem::path existing_file(std::string_view key) const;

  /// `FILE:LINE` of the key, or of this map.
  std::string where(std::string_view key = {}) const;
  [[noreturn]] void fail(std::string_view key, const std::string& what) const;

  /// Refuses keys in this map, or in one below it, that nobody read.
  void finish() const;

  /// The whole file as it stands, without its base.
  const std::string& source() const;
  const std::filesystem::path& file() const;

 private:
  struct Document;
  struct Node;
  Config(std::shared_ptr<const Document> document, Node* node) : document_(std::move(document)), node_(node) {}

  // `above` are the files that build on this one.
  static Config over_base(const std::string& text, const std::filesystem::path& file,
                          std::vector<std::filesystem::path> above);
  const Node* find(std::string_view key) const;
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

/// Any text as a value of a configuration, between quotes: it reads back as it is.
std::string yaml_text(std::string_view text);

/// The word of `known` that is nearest to `word` by spelling, or none where nothing is near.
std::optional<std::string> nearest_spelling(std::string_view word, const std::vector<std::string>& known);

}  // namespace piste
