#pragma once
/// A configuration file as a tree in which every value knows its file and line.

#include <yaml-cpp/yaml.h>

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "piste/io/config.h"

namespace piste {

/// A value, a list or a map.
struct Config::Node {
  struct Entry;
  enum class Kind { kEmpty, kScalar, kList, kMap };
  Kind kind = Kind::kEmpty;
  std::shared_ptr<const std::filesystem::path> file;  ///< in which it stands; it may be that of a base
  int line = 1;
  std::string scalar;
  std::vector<Node> list;
  std::vector<Entry> entries;
  mutable std::vector<std::string> known;  ///< keys that somebody asked for

  std::string where() const { return where(line); }
  std::string where(int at) const;
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
  Node root;

  /// The tree of `yaml`. `line` is its line if it does not know its own. Throws ConfigError.
  Node convert(const YAML::Node& yaml, int line, int depth);

 private:
  void add_entry(Node& node, const YAML::Node& key, const YAML::Node& value, int depth);
  std::size_t values_ = 0;  // so far; an alias counts as all the values of its anchor
};

}  // namespace piste
