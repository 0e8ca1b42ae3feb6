#include "config_document.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <yaml-cpp/eventhandler.h>

#include <algorithm>
#include <array>
#include <fstream>
#include <sstream>
#include <system_error>
#include <utility>

#include "piste/core/error.h"

namespace piste {
namespace {

/// Takes a document and keeps nothing.
struct Discard : YAML::EventHandler {
  using Mark = YAML::Mark;
  using Style = YAML::EmitterStyle::value;
  using Text = std::string;
  void OnDocumentStart(const Mark&) override {}
  void OnDocumentEnd() override {}
  void OnNull(const Mark&, YAML::anchor_t) override {}
  void OnAlias(const Mark&, YAML::anchor_t) override {}
  void OnScalar(const Mark&, const Text&, YAML::anchor_t, const Text&) override {}
  void OnSequenceStart(const Mark&, const Text&, YAML::anchor_t, Style) override {}
  void OnSequenceEnd() override {}
  void OnMapStart(const Mark&, const Text&, YAML::anchor_t, Style) override {}
  void OnMapEnd() override {}
};

// YAML::Load does not read what follows the first document, and YAML::LoadAll never returns on a stray comma.
bool is_one_document(const std::string& text) {
  std::istringstream stream(text);
  YAML::Parser parser(stream);
  Discard discard;
  return parser.HandleNextDocument(discard) && !parser.HandleNextDocument(discard);
}

// Limits that no file written by hand reaches. Larger files are logs, or made to exhaust the parser.
constexpr std::size_t kLongestText = 1'000'000, kMostValues = 20'000;
constexpr int kDeepest = 50;

std::string text_of(const std::filesystem::path& file) {
  std::ifstream stream(file, std::ios::binary);
  if (!stream || std::filesystem::is_directory(file)) {
    throw ConfigError(file.string(), "cannot be read; give the path of a configuration file (YAML)");
  }
  std::string text;
  std::array<char, 4096> part{};
  do {
    stream.read(part.data(), part.size());
    text.append(part.data(), static_cast<std::size_t>(stream.gcount()));
  } while (stream && text.size() <= kLongestText);
  return text;
}

}  // namespace

std::string Config::Node::where(int at) const { return name.empty() ? fmt::format("{}:{}", file->string(), at) : name; }

void Config::Node::complete(Node base) {  // NOLINT(misc-no-recursion)
  for (Entry& e : base.entries) {
    const auto ours = std::find_if(entries.begin(), entries.end(), [&](const Entry& own) { return own.key == e.key; });
    if (ours == entries.end()) {
      entries.push_back(std::move(e));
    } else if (ours->value.kind == Kind::kMap) {
      ours->value.complete(std::move(e.value));  // of another kind it has no entries
    }
  }
}

Config::Node::Known& Config::Node::know(std::string_view key) const {
  const auto found = std::find_if(known.begin(), known.end(), [&](const Known& k) { return k.key == key; });
  return found != known.end() ? *found : known.emplace_back(Known{std::string(key)});
}

std::vector<std::string> Config::Node::known_keys() const {
  std::vector<std::string> keys;
  keys.reserve(known.size());
  for (const Known& k : known) keys.push_back(k.key);
  return keys;
}

void Config::Node::append_asked(const std::string& path,  // NOLINT(misc-no-recursion)
                                std::vector<KeyUse>& asked) const {
  for (const Known& k : known) {
    std::vector<std::string> takes = k.takes;
    if (takes.size() > 1) std::erase(takes, std::string(kText));  // it was looked at before it was read
    KeyUse use{path + k.key, fmt::format("{}", fmt::join(takes, "; or ")), k.fallback, k.optional};
    const auto same =
        std::find_if(asked.begin(), asked.end(), [&](const KeyUse& other) { return other.key == use.key; });
    if (same == asked.end()) {
      asked.push_back(std::move(use));
    } else {  // another map of the same list
      if (same->takes.empty()) same->takes = use.takes;
      if (same->fallback.empty()) same->fallback = use.fallback;
    }
    const auto entry = std::find_if(entries.begin(), entries.end(), [&](const Entry& e) { return e.key == k.key; });
    if (entry == entries.end()) continue;
    entry->value.append_asked(path + k.key + ".", asked);
    for (const Node& item : entry->value.list) item.append_asked(path + k.key + ".", asked);
  }
}

Config::Node Config::Document::convert(const YAML::Node& yaml, int line, int depth,  // NOLINT(misc-no-recursion)
                                       const std::string& path) {
  Node node;
  node.file = file;
  if (names) node.name = names(path);
  node.line = yaml.Mark().line >= 0 ? yaml.Mark().line + 1 : line;
  if (depth > kDeepest || ++values_ > kMostValues) {
    throw ConfigError(node.where(), fmt::format("more than {} maps and lists within each other, or {} values in all; "
                                                "write less, or aliases (`*`) that do not multiply",
                                                kDeepest, kMostValues));
  }
  switch (yaml.Type()) {
    case YAML::NodeType::Undefined:
    case YAML::NodeType::Null:
      break;
    case YAML::NodeType::Scalar:
      node.kind = Node::Kind::kScalar;
      node.scalar = yaml.Scalar();
      break;
    case YAML::NodeType::Sequence:
      node.kind = Node::Kind::kList;
      for (const auto& item : yaml) {
        node.list.push_back(convert(item, node.line, depth + 1, fmt::format("{}[{}]", path, node.list.size())));
      }
      break;
    case YAML::NodeType::Map:
      node.kind = Node::Kind::kMap;
      for (const auto& item : yaml) add_entry(node, item.first, item.second, depth + 1, path);
      break;
  }
  return node;
}

void Config::Document::add_entry(Node& node, const YAML::Node& key,
                                 const YAML::Node& value,  // NOLINT(misc-no-recursion)
                                 int depth, const std::string& path) {
  const int line = key.Mark().line + 1;
  if (!key.IsScalar()) throw ConfigError(node.where(line), "a key must be a word");
  const auto same = [&](const Node::Entry& e) { return e.key == key.Scalar(); };
  if (const auto first = std::find_if(node.entries.begin(), node.entries.end(), same); first != node.entries.end()) {
    throw ConfigError(
        node.where(line),
        fmt::format("key `{}` stands here a second time; it is already in line {}, keep one", first->key, first->line));
  }
  node.entries.push_back(
      {key.Scalar(), line, convert(value, line, depth, path.empty() ? key.Scalar() : path + '.' + key.Scalar())});
}

Config Config::load(const std::filesystem::path& file) { return parse(text_of(file), file); }

Config Config::parse(const std::string& text, const std::filesystem::path& file, NamedColumns tables, KeyNames names) {
  return over_base(text, file, {}, std::move(tables), std::move(names));
}

Config Config::over_base(const std::string& text, const std::filesystem::path& file,  // NOLINT(misc-no-recursion)
                         std::vector<std::filesystem::path> above, NamedColumns tables, KeyNames names) {
  auto document = std::make_shared<Document>();
  document->names = std::move(names);
  document->tables = std::move(tables);
  document->file = std::make_shared<const std::filesystem::path>(file);
  document->source = text;
  Node& root = document->root;
  root.file = document->file;
  if (text.size() > kLongestText) {
    throw ConfigError(
        file.string(),
        fmt::format("is longer than {} bytes; give the path of a configuration file (YAML)", kLongestText));
  }
  try {
    const YAML::Node yaml = YAML::Load(text);
    if (!yaml.IsMap() || !is_one_document(text)) {
      throw ConfigError(root.where(1), "one map of `key: value` lines is expected");
    }
    root = document->convert(yaml, 1, 0, "");
  } catch (const YAML::Exception& e) {
    throw ConfigError(root.where(std::max(e.mark.line, 0) + 1),
                      fmt::format("no YAML: {}; write `key: value` lines, indented by spaces", e.msg));
  }
  Config config(document, &root);
  config.know("base", "a file");
  if (!config.has("base")) return config;

  const std::filesystem::path base = config.existing_file("base");
  above.push_back(file);
  const auto same = [&](const std::filesystem::path& other) {
    std::error_code unreachable;
    return std::filesystem::equivalent(base, other, unreachable);
  };
  if (std::any_of(above.begin(), above.end(), same)) {
    config.fail("base", fmt::format("`{}` builds on this file itself; a base must lead to a file without `base`",
                                    base.string()));
  }
  root.complete(std::move(*over_base(text_of(base), base, std::move(above)).node_));
  return config;
}

}  // namespace piste
