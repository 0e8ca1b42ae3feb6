#include "tagged_rows.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <utility>

#include "column_names.h"

namespace piste {
namespace {

constexpr std::size_t kNamesWithin = 256 << 10;  // bytes at the beginning, in which names are looked for
constexpr std::size_t kFewest = 4;               // columns of a message with a triad, or a place

// The columns of a message as the log names them, without that of its name.
struct Named {
  std::string tag;
  std::vector<std::string> names, units;
};

using Fields = std::vector<std::string_view>;

std::vector<std::string> behind(const Fields& fields, std::size_t first) {
  return {fields.begin() + static_cast<std::ptrdiff_t>(std::min(first, fields.size())), fields.end()};
}

// The columns of a message that a line declares, if it declares any.
void take(const Fields& fields, std::vector<Named>& found) {
  constexpr std::size_t kFlySight = 2, kAutopilot = 5;  // where the names begin
  constexpr std::string_view kComment = "# ";
  const auto add = [&](std::string tag, std::size_t first) {
    if (!tag.empty() && fields.size() >= first + kFewest - 1)
      found.push_back({std::move(tag), behind(fields, first), {}});
  };
  if (fields[0] == "$COL" && fields.size() > kFlySight) add(fmt::format("${}", fields[1]), kFlySight);
  if (fields[0] == "FMT" && fields.size() > kAutopilot) add(std::string(fields[3]), kAutopilot);
  if (fields[0].starts_with(kComment)) add(std::string(fields[0].substr(kComment.size())), 1);
  if (fields[0] != "$UNIT" || fields.size() < kFlySight) return;
  for (Named& message : found) {
    if (message.tag.substr(1) == fields[1]) message.units = behind(fields, kFlySight);
  }
}

std::vector<Named> named_messages(std::string_view text) {
  std::vector<Named> found;
  TextReader reader("", TextReader::Separator::kComma, text.substr(0, kNamesWithin));
  while (reader.next()) take(reader.fields(), found);
  return found;
}

ColumnTable table_of(const Named& message) {
  std::vector<HeaderCell> cells{HeaderCell{"", "", ""}};
  std::vector<std::string_view> names(message.names.begin(), message.names.end());
  std::vector<std::string_view> units(message.units.begin(), message.units.end());
  std::vector<HeaderCell> named = header_cells(names, names.size());
  add_units(named, units);
  cells.insert(cells.end(), named.begin(), named.end());
  return table_with(std::move(cells), true);
}

// Whether the columns may be those of an IMU or a receiver: autopilots have a hundred other messages.
bool may_be_log(const ColumnTable& table) {
  constexpr std::array<std::string_view, 6> kKeys{"gyro", "accel", "dtheta", "dvel", "axis", "latitude"};
  return std::any_of(table.columns.begin(), table.columns.end(), [&](const SampledColumn& c) {
    return std::find(kKeys.begin(), kKeys.end(), meaning_of(c).key) != kKeys.end();
  });
}

}  // namespace

std::vector<TaggedRows> tagged_rows(std::string_view text) {
  std::vector<TaggedRows> found;
  for (const Named& message : named_messages(text)) {
    ColumnTable table = table_of(message);
    if (!may_be_log(table)) continue;
    sample_rows(text, TextReader::Separator::kComma, table,
                [&](const Fields& fields) { return fields[0] == message.tag; });
    if (table.rows > 2) found.push_back({message.tag, std::move(table)});
  }
  return found;
}

std::vector<std::pair<double, double>> tagged_clock(std::string_view text) {
  constexpr auto kComma = TextReader::Separator::kComma;
  std::vector<std::pair<double, double>> pairs;
  const std::vector<std::string> expected{"time", "tow", "week"};
  for (const Named& message : named_messages(text)) {
    if (message.names != expected) continue;
    TextReader reader("", kComma, text);
    while (reader.next()) {
      const Fields& fields = reader.fields();
      if (fields[0] != message.tag || fields.size() != 1 + expected.size()) continue;
      const auto time = number_in(fields[1], kComma), seconds = number_in(fields[2], kComma);
      if (time && seconds) pairs.emplace_back(*time, *seconds);
    }
  }
  return pairs;
}

}  // namespace piste
