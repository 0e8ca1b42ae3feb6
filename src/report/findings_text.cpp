#include "piste/report/findings_text.h"

#include <fmt/format.h>

#include "report/findings_tables.h"

namespace piste {
namespace {

std::string text_of(const TextTable& rows) {
  std::string out;
  for (const std::vector<std::string>& cells : rows) {
    std::string line;
    for (std::size_t i = 0; i < cells.size(); ++i) line += fmt::format("{:<{}}", cells[i], i == 0 ? 10 : 23);
    line.erase(line.find_last_not_of(' ') + 1);
    out += line + "\n";
  }
  return out;
}

}  // namespace

std::string findings_text(const Findings& found) {
  std::string out = phases_text(found) + "\n" + text_of(findings_by_axis(found));
  for (const TextTable& triad : findings_by_triad(found)) out += text_of(triad);
  return out;
}

}  // namespace piste
