#pragma once
/// A small check that markup nests, and the part of a page that it is for.

#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace piste::test {

/// Empty where every element of `xml` is closed in its order and nothing is left of & or < in text; else what is wrong.
inline std::string not_well_formed(const std::string& xml) {
  std::vector<std::string> open;
  std::size_t at = 0;
  while (at < xml.size()) {
    const std::size_t tag = xml.find('<', at), entity = xml.find('&', at);
    if (entity < tag) {
      const std::size_t end = xml.find(';', entity);
      if (end == std::string::npos || end - entity > 8) return "bare & at " + xml.substr(entity, 20);
      at = end;
      continue;
    }
    if (tag == std::string::npos) break;
    const std::size_t end = xml.find('>', tag);
    if (end == std::string::npos) return "unclosed tag at " + xml.substr(tag, 20);
    const std::string inside = xml.substr(tag + 1, end - tag - 1);
    at = end + 1;
    if (inside.front() == '?' || inside.back() == '/') continue;
    if (inside.front() != '/') {
      open.push_back(inside.substr(0, inside.find_first_of(" \n")));
    } else if (open.empty() || open.back() != inside.substr(1)) {
      return "</" + inside.substr(1) + "> closes nothing";
    } else {
      open.pop_back();
    }
  }
  return open.empty() ? "" : "<" + open.back() + "> is never closed";
}

/// What a page has between <main> and the end of its body, without its scripts.
inline std::string body_of(const std::string& page) {
  constexpr std::string_view kEnd = "</main>";
  const std::size_t from = page.find("<main>"), to = page.find(kEnd);
  return page.substr(from, to + kEnd.size() - from);
}

/// A page without its styles and its scripts but for the numbers of the charts.
inline std::string without_libraries(std::string page) {
  for (const auto& [open, close] :
       {std::pair<std::string, std::string>{"<style>", "</style>"}, {"<script>", "</script>"}}) {
    for (std::size_t at = page.find(open); at != std::string::npos; at = page.find(open, at)) {
      page.erase(at, page.find(close, at) + close.size() - at);
    }
  }
  return page;
}

}  // namespace piste::test
