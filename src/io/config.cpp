#include "piste/io/config.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cctype>
#include <charconv>
#include <cmath>
#include <iterator>
#include <sstream>
#include <stdexcept>
#include <system_error>

#include "config_document.h"
#include "piste/core/error.h"

namespace piste {

namespace {

// The unit of an example such as `0.5 deg/s`. A ratio is written without.
std::string_view unit_of(const Dimension& dimension) {
  if (dimension == dimension::kRatio) return {};
  return dimension.example.substr(dimension.example.find(' ') + 1);
}

// Values in the unit of the example, as a reader of the manual wants them: with five digits.
std::string shown(std::span<const double> values, const Dimension& dimension) {
  const std::string_view unit = unit_of(dimension);
  const double factor = unit_factor(unit, dimension);
  std::string text;
  for (const double value : values) {
    if (!std::isfinite(value)) return {};
    text += fmt::format("{:.5g} ", value / factor);
  }
  text += unit;
  if (unit.empty()) text.pop_back();
  return text;
}

std::string example_of_three(const Dimension& dimension) {
  const std::string_view number = dimension.example.substr(0, dimension.example.find(' '));
  if (dimension == dimension::kRatio) return "0.01 0.01 0.01";
  return fmt::format("{0} {0} {0} {1}", number, unit_of(dimension));
}

}  // namespace

const Config::Node* Config::find(std::string_view key) const {
  node_->know(key);
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
  node_->know(key).optional = true;
  return std::any_of(node_->entries.begin(), node_->entries.end(), [&](const auto& e) { return e.key == key; });
}

std::vector<std::string> Config::names() const {
  std::vector<std::string> names;
  for (const Node::Entry& e : node_->entries) names.push_back(e.key);
  return names;
}

void Config::know(std::string_view key, std::string_view takes, std::string_view fallback) const {
  Node::Known& known = node_->know(key);
  if (std::find(known.takes.begin(), known.takes.end(), takes) == known.takes.end()) known.takes.emplace_back(takes);
  if (known.fallback.empty()) known.fallback = fallback;
}

void Config::know_choice(std::string_view key, const std::vector<std::string_view>& names,
                         std::string_view fallback) const {
  std::vector<std::string_view> words;  // without signs that stand for them, such as `,` for comma
  std::copy_if(names.begin(), names.end(), std::back_inserter(words),
               [](std::string_view name) { return std::isalpha(static_cast<unsigned char>(name.front())) != 0; });
  know(key, fmt::format("`{}`", fmt::join(words, "`, `")), fallback);
}

std::vector<KeyUse> Config::asked() const {
  std::vector<KeyUse> asked;
  node_->append_asked("", asked);
  return asked;
}

bool Config::is_map(std::string_view key) const {
  return std::any_of(node_->entries.begin(), node_->entries.end(),
                     [&](const auto& e) { return e.key == key && e.value.kind == Node::Kind::kMap; });
}

bool Config::is_scalar(std::string_view key) const {
  node_->know(key).optional = true;
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
  const auto entry = std::ranges::find(node_->entries, key, &Node::Entry::key);
  const bool named = entry != node_->entries.end() && !entry->value.name.empty();
  throw ConfigError(where(key), key.empty() || named ? what : fmt::format("{}: {}", key, what));
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
  know(key, "a map");
  const Node& node = require(key);
  if (node.kind != Node::Kind::kMap) fail(key, "must be a map of `key: value`");
  return {document_, const_cast<Node*>(&node)};
}

std::optional<Config> Config::find_map(std::string_view key) const {
  know(key, "a map");
  if (!has(key)) return std::nullopt;
  return map(key);
}

std::vector<Config> Config::maps(std::string_view key) const {
  know(key, "a map, or a list of maps");
  node_->know(key).optional = true;
  const Node* node = find(key);
  if (node == nullptr) return {};
  if (node->kind == Node::Kind::kMap) return {Config(document_, const_cast<Node*>(node))};
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
  know(key, fmt::format("{}, such as `{}`", expected.name, expected.example),
       fallback ? shown({&*fallback, 1}, expected) : "");
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
  know(key, fmt::format("{} along each axis, such as `{}`", expected.name, example_of_three(expected)),
       fallback ? shown({fallback->data(), 3}, expected) : "");
  if (fallback && !has(key)) return *fallback;
  return checked(key, [&](const std::string& text) { return parse_vector(text, expected); });
}

double Config::number(std::string_view key, std::optional<double> fallback) const {
  know(key, "a number", fallback ? shown({&*fallback, 1}, dimension::kRatio) : "");
  if (fallback && !has(key)) return *fallback;
  return checked(key, [&](const std::string& text) { return parse_quantity(text, dimension::kRatio); });
}

long Config::integer(std::string_view key, std::optional<long> fallback) const {
  know(key, "a whole number", fallback ? fmt::to_string(*fallback) : "");
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
  know(key, kText, fallback.value_or(""));
  if (fallback && !has(key)) return *fallback;
  return scalar(key);
}

std::vector<std::string> Config::words(std::string_view key) const {
  know(key, "words, or a list of them");
  node_->know(key).optional = true;
  const Node* node = find(key);
  std::vector<std::string> result;
  if (node == nullptr) return result;
  if (node->kind == Node::Kind::kMap) fail(key, "must be a list of words");
  if (node->kind == Node::Kind::kScalar) {
    std::istringstream stream(node->scalar);
    for (std::string word; stream >> word;) {
      if (word.size() > 1 && word.back() == ',') word.pop_back();
      result.push_back(word);
    }
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
  know(key, fmt::format("a list of pairs, each {0}, such as `[[{1}, {1}]]`", expected.name, expected.example));
  node_->know(key).optional = true;
  const Node* node = find(key);
  std::vector<std::pair<double, double>> result;
  if (node == nullptr) return result;
  if (node->kind != Node::Kind::kList) fail(key, "must be a list of pairs, such as [[100 s, 15 s], [200 s, 15 s]]");
  for (const Node& item : node->list) result.push_back(pair_of(key, item, expected));
  return result;
}

std::pair<double, double> Config::pair(std::string_view key, const Dimension& expected) const {
  know(key, fmt::format("a pair, each {0}, such as `[{1}, {1}]`", expected.name, expected.example));
  return pair_of(key, require(key), expected);
}

std::size_t Config::index_of_choice(std::string_view key, const std::vector<std::string_view>& names) const {
  const std::string& word = scalar(key);
  const auto found = std::find(names.begin(), names.end(), word);
  if (found == names.end()) fail(key, fmt::format("`{}` is none of: {}", word, fmt::join(names, ", ")));
  return static_cast<std::size_t>(found - names.begin());
}

Matrix3d Config::axes(std::string_view key) const {
  know(key, "three sensor axes, such as `+y -x +z`", "+x +y +z");
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
  know(key, "a file");
  return (require(key).file->parent_path() / scalar(key)).lexically_normal();
}

std::filesystem::path Config::existing_file(std::string_view key) const {
  std::filesystem::path result = path(key);
  std::error_code unreachable;  // such as a name too long
  if (!std::filesystem::is_regular_file(result, unreachable)) {
    const Node& node = require(key);
    fail(key, fmt::format("there is no file `{}`; paths are relative to {}", result.string(),
                          node.name.empty() ? "the folder of " + node.file->string() : "the current folder"));
  }
  return result;
}

const NumberColumns* Config::table(std::string_view key) const {
  const auto place = document_->tables.find(scalar(key));
  return place == document_->tables.end() ? nullptr : &place->second;
}

// ---- The end ----

void Config::finish() const { finish(*node_); }

void Config::finish(const Node& node) const {  // NOLINT(misc-no-recursion)
  for (const Node::Entry& e : node.entries) {
    const std::vector<std::string> known = node.known_keys();
    if (std::find(known.begin(), known.end(), e.key) == known.end()) {
      const auto near = nearest_spelling(e.key, known);
      throw ConfigError(e.where(),
                        fmt::format("unknown key `{}`{}; known here are: {}", e.key,
                                    near ? fmt::format(", perhaps `{}`", *near) : "", fmt::join(known, ", ")));
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

}  // namespace piste
