#pragma once
/// A configuration file as a tree in which every value knows its file and line.

#include <yaml-cpp/yaml.h>

#include <filesystem>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "piste/io/config.h"

namespace piste {

/// The type of a key that was read as text.
inline constexpr std::string_view kText = "text";

/// A value, a list or a map.
struct Config::Node {
  struct Entry;
  /// A key that a reader asked for, and the values that it takes.
  struct Known {
    std::string key;
    std::vector<std::string> takes = {};
    std::string fallback = {};
    bool optional = false;  ///< it may be missing
  };
  enum class Kind { kEmpty, kScalar, kList, kMap };
  Kind kind = Kind::kEmpty;
  std::shared_ptr<const std::filesystem::path> file;  ///< in which it stands; it may be that of a base
  int line = 1;
  std::string name;  ///< what errors call it; empty: file and line
  std::string scalar;
  std::vector<Node> list;
  std::vector<Entry> entries;
  mutable std::vector<Known> known;  ///< keys that a reader asked for

  std::string where() const { return where(line); }
  std::string where(int at) const;
  /// The entry of a key in `known`; adds it if it is missing.
  Known& know(std::string_view key) const;
  std::vector<std::string> known_keys() const;
  /// Appends the keys asked of this map and of the maps below it, with `path` before each key.
  void append_asked(const std::string& path, std::vector<KeyUse>& asked) const;
  /// Adds the keys of `base` that this map does not have, and does the same in the maps that both have.
  void complete(Node base);
};

/// A key of a map, and its value.
struct Config::Node::Entry {
  std::string key;
  int line = 1;
  Node value;
  mutable bool read = false;

  std::string where() const { return value.where(line); }
};

/// One file.
struct Config::Document {
  std::shared_ptr<const std::filesystem::path> file;
  std::string source;
  NamedColumns tables = {};
  KeyNames names = {};
  Node root;

  /// The tree of `yaml`. `line` is its line if it does not know its own. Throws ConfigError.
  Node convert(const YAML::Node& yaml, int line, int depth, const std::string& path);

 private:
  void add_entry(Node& node, const YAML::Node& key, const YAML::Node& value, int depth, const std::string& path);
  std::size_t values_ = 0;  // so far; an alias counts as all the values of its anchor
};

}  // namespace piste
