#include "piste/io/config.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <yaml-cpp/eventhandler.h>
#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <fstream>
#include <sstream>
#include <stdexcept>
#include <system_error>

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

// YAML::Load leaves unread what follows the first document, and YAML::LoadAll never ends on a stray comma.
bool is_one_document(const std::string& text) {
  std::istringstream stream(text);
  YAML::Parser parser(stream);
  Discard discard;
  return parser.HandleNextDocument(discard) && !parser.HandleNextDocument(discard);
}

// What nobody writes by hand: a log, or a file made to burst a parser.
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

struct Config::Node {
  struct Entry;
  enum class Kind { kEmpty, kScalar, kList, kMap };
  Kind kind = Kind::kEmpty;
  std::shared_ptr<const std::filesystem::path> file;  // in which it stands: maps hold what bases gave them
  int line = 1;
  std::string scalar;
  std::vector<Node> list;
  std::vector<Entry> entries;
  mutable std::vector<std::string> known;  // keys that somebody asked for

  std::string where() const { return where(line); }
  std::string where(int at) const { return fmt::format("{}:{}", file->string(), at); }
  void complete(Node base);
};

struct Config::Node::Entry {
  std::string key;
  int line = 1;
  Node value;
  mutable bool read = false;

  std::string where() const { return value.where(line); }
};

// Adds what this map has not: map by map, while scalars and lists stay whole.
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

struct Config::Document {
  std::shared_ptr<const std::filesystem::path> file;
  std::string source;
  Node root;
  std::size_t values = 0;  // so far: an alias stands for all of its anchor

  Node convert(const YAML::Node& yaml, int line, int depth) {  // NOLINT(misc-no-recursion)
    Node node;
    node.file = file;
    node.line = yaml.Mark().line >= 0 ? yaml.Mark().line + 1 : line;
    if (depth > kDeepest || ++values > kMostValues) {
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
        for (const auto& item : yaml) node.list.push_back(convert(item, node.line, depth + 1));
        break;
      case YAML::NodeType::Map:
        node.kind = Node::Kind::kMap;
        for (const auto& item : yaml) add_entry(node, item.first, item.second, depth + 1);
        break;
    }
    return node;
  }

  void add_entry(Node& node, const YAML::Node& key, const YAML::Node& value,  // NOLINT(misc-no-recursion)
                 int depth) {
    const int line = key.Mark().line + 1;
    if (!key.IsScalar()) throw ConfigError(node.where(line), "a key must be a word");
    const auto same = [&](const Node::Entry& e) { return e.key == key.Scalar(); };
    if (const auto first = std::find_if(node.entries.begin(), node.entries.end(), same); first != node.entries.end()) {
      throw ConfigError(node.where(line),
                        fmt::format("key `{}` stands here a second time; it is already in line {}, keep one",
                                    first->key, first->line));
    }
    node.entries.push_back({key.Scalar(), line, convert(value, line, depth)});
  }
};

Config Config::load(const std::filesystem::path& file) { return parse(text_of(file), file); }

Config Config::parse(const std::string& text, const std::filesystem::path& file) { return over_base(text, file, {}); }

Config Config::over_base(const std::string& text, const std::filesystem::path& file,  // NOLINT(misc-no-recursion)
                         std::vector<std::filesystem::path> above) {
  auto document = std::make_shared<Document>();
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
    root = document->convert(yaml, 1, 0);
  } catch (const YAML::Exception& e) {
    throw ConfigError(root.where(std::max(e.mark.line, 0) + 1),
                      fmt::format("no YAML: {}; write `key: value` lines, indented by spaces", e.msg));
  }
  Config config(document, &root);
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

// ---- Keys ----

const Config::Node* Config::find(std::string_view key) const {
  if (std::find(node_->known.begin(), node_->known.end(), key) == node_->known.end()) node_->known.emplace_back(key);
  for (const Node::Entry& e : node_->entries) {
    if (e.key == key) {
      e.read = true;
      if (e.value.kind == Node::Kind::kEmpty) fail(key, "has no value");
      return &e.value;
    }
  }
  return nullptr;
}

bool Config::has(std::string_view key) const {
  if (std::find(node_->known.begin(), node_->known.end(), key) == node_->known.end()) node_->known.emplace_back(key);
  return std::any_of(node_->entries.begin(), node_->entries.end(), [&](const auto& e) { return e.key == key; });
}

bool Config::is_scalar(std::string_view key) const {
  const Node* node = find(key);
  return node != nullptr && node->kind == Node::Kind::kScalar;
}

const Config::Node& Config::require(std::string_view key) const {
  if (const Node* node = find(key)) return *node;
  std::vector<std::string> unread;
  for (const Node::Entry& e : node_->entries) {
    if (!e.read) unread.push_back(e.key);
  }
  const auto near = nearest_spelling(key, unread);
  throw ConfigError(where(), fmt::format("key `{}` is missing{}", key, near ? fmt::format(" (`{}`?)", *near) : ""));
}

const std::string& Config::scalar(std::string_view key) const {
  const Node& node = require(key);
  if (node.kind != Node::Kind::kScalar) fail(key, "must be a single value");
  return node.scalar;
}

std::string Config::where(std::string_view key) const {
  for (const Node::Entry& e : node_->entries) {
    if (e.key == key) return e.where();
  }
  return node_->where();
}

void Config::fail(std::string_view key, const std::string& what) const {
  throw ConfigError(where(key), key.empty() ? what : fmt::format("{}: {}", key, what));
}

template <class F>
auto Config::checked(std::string_view key, F&& parse) const {
  try {
    return parse(scalar(key));
  } catch (const std::invalid_argument& e) {
    fail(key, e.what());
  }
}

// ---- Maps ----

Config Config::map(std::string_view key) const {
  const Node& node = require(key);
  if (node.kind != Node::Kind::kMap) fail(key, "must be a map of `key: value`");
  return {document_, const_cast<Node*>(&node)};
}

std::optional<Config> Config::find_map(std::string_view key) const {
  if (!has(key)) return std::nullopt;
  return map(key);
}

std::vector<Config> Config::maps(std::string_view key) const {
  const Node* node = find(key);
  if (node == nullptr) return {};
  if (node->kind == Node::Kind::kMap) return {map(key)};
  if (node->kind != Node::Kind::kList) fail(key, "must be a map of `key: value`, or a list of such maps");
  std::vector<Config> result;
  for (const Node& item : node->list) {
    if (item.kind != Node::Kind::kMap) throw ConfigError(item.where(), fmt::format("{}: must be a list of maps", key));
    result.push_back({document_, const_cast<Node*>(&item)});
  }
  return result;
}

// ---- Values ----

double Config::quantity(std::string_view key, const Dimension& expected, std::optional<double> fallback) const {
  if (fallback && !has(key)) return *fallback;
  return checked(key, [&](const std::string& text) { return parse_quantity(text, expected); });
}

double Config::magnitude(std::string_view key, const Dimension& expected, std::optional<double> fallback) const {
  const double value = quantity(key, expected, fallback);
  if (value < 0) fail(key, fmt::format("must not be negative; such as `{}`", expected.example));
  return value;
}

Vector3d Config::vector(std::string_view key, const Dimension& expected,
                        const std::optional<Vector3d>& fallback) const {
  if (fallback && !has(key)) return *fallback;
  return checked(key, [&](const std::string& text) { return parse_vector(text, expected); });
}

double Config::number(std::string_view key, std::optional<double> fallback) const {
  return quantity(key, dimension::kRatio, fallback);
}

long Config::integer(std::string_view key, std::optional<long> fallback) const {
  if (fallback && !has(key)) return *fallback;
  const std::string& text = scalar(key);
  long value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc{} || end != text.data() + text.size()) {
    fail(key, fmt::format("`{}` is no whole number", text));
  }
  return value;
}

bool Config::flag(std::string_view key, std::optional<bool> fallback) const {
  return choice<bool>(key, {{"true", true}, {"false", false}}, fallback);
}

std::string Config::text(std::string_view key, const std::optional<std::string>& fallback) const {
  if (fallback && !has(key)) return *fallback;
  return scalar(key);
}

std::vector<std::string> Config::words(std::string_view key) const {
  const Node* node = find(key);
  std::vector<std::string> result;
  if (node == nullptr) return result;
  if (node->kind == Node::Kind::kMap) fail(key, "must be a list of words");
  if (node->kind == Node::Kind::kScalar) {
    std::istringstream stream(node->scalar);
    for (std::string word; stream >> word;) result.push_back(word);
  }
  for (const Node& item : node->list) {
    if (item.kind != Node::Kind::kScalar)
      throw ConfigError(item.where(), fmt::format("{}: must be a list of words", key));
    result.push_back(item.scalar);
  }
  return result;
}

std::pair<double, double> Config::pair_of(std::string_view key, const Node& node, const Dimension& expected) const {
  const auto wrong = [&](const std::string& why) {
    return ConfigError(node.where(), fmt::format("{}: {}; right would be such as [100 s, 15 s]", key, why));
  };
  if (node.kind != Node::Kind::kList || node.list.size() != 2) throw wrong("two values in brackets are expected");
  const auto value = [&](const Node& item) {
    try {
      const bool bare = item.scalar.find_first_not_of("+-0123456789.eE") == std::string::npos;
      return parse_quantity(item.scalar, bare ? dimension::kRatio : expected);
    } catch (const std::invalid_argument& e) {
      throw wrong(e.what());
    }
  };
  return {value(node.list[0]), value(node.list[1])};
}

std::vector<std::pair<double, double>> Config::pairs(std::string_view key, const Dimension& expected) const {
  const Node* node = find(key);
  std::vector<std::pair<double, double>> result;
  if (node == nullptr) return result;
  if (node->kind != Node::Kind::kList) fail(key, "must be a list of pairs, such as [[100 s, 15 s], [200 s, 15 s]]");
  for (const Node& item : node->list) result.push_back(pair_of(key, item, expected));
  return result;
}

std::pair<double, double> Config::pair(std::string_view key, const Dimension& expected) const {
  return pair_of(key, require(key), expected);
}

std::size_t Config::index_of_choice(std::string_view key, const std::vector<std::string_view>& names) const {
  const std::string& word = scalar(key);
  const auto found = std::find(names.begin(), names.end(), word);
  if (found == names.end()) fail(key, fmt::format("`{}` is none of: {}", word, fmt::join(names, ", ")));
  return static_cast<std::size_t>(found - names.begin());
}

Matrix3d Config::axes(std::string_view key) const {
  if (!has(key)) return Matrix3d::Identity();
  const std::vector<std::string> names = words(key);
  Matrix3d R_bs = Matrix3d::Zero();
  bool good = names.size() == 3;
  for (std::size_t row = 0; good && row < 3; ++row) {
    std::string_view name = names[row];
    const double sign = name.starts_with('-') ? -1 : 1;
    if (name.starts_with('-') || name.starts_with('+')) name.remove_prefix(1);
    good = name.size() == 1 && name[0] >= 'x' && name[0] <= 'z';
    if (good) R_bs(static_cast<int>(row), name[0] - 'x') = sign;
  }
  if (!good) fail(key, "must name three sensor axes, such as `+x +y +z` or `+y -x +z`");
  if (std::abs(R_bs.determinant() - 1) > 1e-12) {
    fail(key, fmt::format("`{}` is no right-handed frame; each axis once, and turn one sign", fmt::join(names, " ")));
  }
  return R_bs;
}

std::filesystem::path Config::path(std::string_view key) const {
  return (require(key).file->parent_path() / scalar(key)).lexically_normal();
}

std::filesystem::path Config::existing_file(std::string_view key) const {
  std::filesystem::path result = path(key);
  std::error_code unreachable;  // such as a name too long
  if (!std::filesystem::is_regular_file(result, unreachable)) {
    fail(key, fmt::format("there is no file `{}`; paths are relative to the folder of {}", result.string(),
                          require(key).file->string()));
  }
  return result;
}

// ---- The end ----

void Config::finish() const { finish(*node_); }

void Config::finish(const Node& node) const {  // NOLINT(misc-no-recursion)
  for (const Node::Entry& e : node.entries) {
    const bool known = std::find(node.known.begin(), node.known.end(), e.key) != node.known.end();
    if (!known) {
      const auto near = nearest_spelling(e.key, node.known);
      throw ConfigError(e.where(),
                        fmt::format("unknown key `{}`{}; known here are: {}", e.key,
                                    near ? fmt::format(", perhaps `{}`", *near) : "", fmt::join(node.known, ", ")));
    }
    if (!e.read) throw ConfigError(e.where(), fmt::format("key `{}` has no use here; remove it", e.key));
    if (e.value.kind == Node::Kind::kMap) finish(e.value);
    for (const Node& item : e.value.list) {
      if (item.kind == Node::Kind::kMap) finish(item);
    }
  }
}

const std::string& Config::source() const { return document_->source; }
const std::filesystem::path& Config::file() const { return *document_->file; }

std::string yaml_text(std::string_view text) {
  // Single quotes fold line ends; where there are control characters only double quotes keep what stands.
  const bool plain = std::none_of(text.begin(), text.end(), [](unsigned char c) { return c < 0x20 || c == 0x7F; });
  std::string out(1, plain ? '\'' : '"');
  for (const char c : text) {
    const auto byte = static_cast<unsigned char>(c);
    if (plain) {
      out += c == '\'' ? "''" : std::string(1, c);
    } else if (byte < 0x20 || byte == 0x7F) {
      out += fmt::format("\\x{:02x}", byte);
    } else {
      if (c == '"' || c == '\\') out += '\\';
      out += c;
    }
  }
  return out + out.front();
}

std::optional<std::string> nearest_spelling(std::string_view word, const std::vector<std::string>& known) {
  const auto distance = [](std::string_view a, std::string_view b) {  // Levenshtein
    std::vector<std::size_t> row(b.size() + 1);
    for (std::size_t j = 0; j <= b.size(); ++j) row[j] = j;
    for (std::size_t i = 1; i <= a.size(); ++i) {
      std::size_t diagonal = row[0];
      row[0] = i;
      for (std::size_t j = 1; j <= b.size(); ++j) {
        const std::size_t replaced = diagonal + (a[i - 1] == b[j - 1] ? 0 : 1);
        diagonal = row[j];
        row[j] = std::min({row[j] + 1, row[j - 1] + 1, replaced});
      }
    }
    return row.back();
  };
  std::optional<std::string> best;
  std::size_t least = 1 + std::max<std::size_t>(1, word.size() / 3);
  for (const std::string& k : known) {
    if (const std::size_t d = distance(word, k); d < least) {
      least = d;
      best = k;
    }
  }
  return best;
}

}  // namespace piste
