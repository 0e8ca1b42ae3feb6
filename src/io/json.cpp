#include "io/json.h"

#include <fmt/ranges.h>

namespace piste::json {
std::string string(std::string_view text) {
  std::string out = "\"";
  for (const char c : text) {
    if (c == '"' || c == '\\') {
      out += '\\';
      out += c;
    } else if (c == '<' || static_cast<unsigned char>(c) < 0x20) {
      out += fmt::format("\\u{:04x}", static_cast<unsigned char>(c));
    } else {
      out += c;
    }
  }
  return out + '"';
}

std::string array(const std::vector<std::string>& items) { return fmt::format("[{}]", fmt::join(items, ", ")); }

std::string strings(const std::vector<std::string>& texts) {
  std::vector<std::string> items;
  items.reserve(texts.size());
  for (const std::string& text : texts) items.push_back(string(text));
  return array(items);
}

std::string object(const Members& members) {
  std::string text = "{";
  for (const auto& [name, value] : members) {
    text += fmt::format("{}{}: {}", text.size() > 1 ? ", " : "", string(name), value);
  }
  return text + "}";
}

std::string object(const Members& members, int depth) {
  const std::string indent(static_cast<std::size_t>(2 * depth), ' ');
  std::string text = "{";
  for (const auto& [name, value] : members) {
    text += fmt::format("{}\n{}  {}: {}", text.size() > 1 ? "," : "", indent, string(name), value);
  }
  return text + "\n" + indent + "}";
}

}  // namespace piste::json
