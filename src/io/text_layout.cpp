#include "io/text_layout.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <map>
#include <utility>

namespace piste {
namespace {

constexpr std::size_t kLooked = 64 << 10;   // bytes
constexpr std::string_view kMarks = "#%/";  // of comments

// One line that is not empty.
struct Line {
  std::size_t number = 0;
  std::size_t fields = 0, whole = 0;  ///< number of fields, and without an empty one behind the last delimiter
  bool is_row = false;                ///< whether most of its fields are numbers or empty
  bool is_units = false;              ///< whether most of its fields are units
};

std::string_view without(std::string_view text, std::string_view marks) {
  const auto first = text.find_first_not_of(marks);
  if (first == std::string_view::npos) return {};
  return text.substr(first, text.find_last_not_of(marks) - first + 1);
}

// The line of VBOX between the names and the rows.
constexpr std::string_view kDataMark = "[data]";

// Whether the first field is but the mark of a comment.
bool begins_with_mark(const std::vector<std::string_view>& fields) {
  return fields.size() > 1 && !fields[0].empty() && without(fields[0], kMarks).empty();
}

// A unit from a line of units, without brackets or quotes: `deg/s`, `(deg/s)` or `"deg/s"`.
std::string_view bare(std::string_view field) {
  const std::string_view unit = without(field, " \t\"");
  const bool bracketed =
      unit.size() > 1 && ((unit.front() == '(' && unit.back() == ')') || (unit.front() == '[' && unit.back() == ']'));
  return bracketed ? without(unit.substr(1, unit.size() - 2), " \t") : unit;
}

bool is_unit(std::string_view text) {
  const std::array measured{dimension::kTime,         dimension::kLength,       dimension::kVelocity,
                            dimension::kAcceleration, dimension::kAngle,        dimension::kAngularRate,
                            dimension::kTemperature,  dimension::kMagneticField};
  return std::any_of(measured.begin(), measured.end(), [&](const Dimension& d) { return measures(text, d); });
}

bool are_units(const std::vector<std::string_view>& fields) {
  std::size_t said = 0, units = 0;
  for (const std::string_view field : fields) {
    if (without(field, " \t\"").empty()) continue;
    ++said;
    units += is_unit(bare(field)) ? 1 : 0;
  }
  return units > 1 && 2 * units >= said;
}

// Whether a line is one of the chosen rows. Only numbered columns are compared.
bool are_chosen(const std::vector<std::string_view>& fields, const std::vector<ColumnRows>& chosen) {
  return std::all_of(chosen.begin(), chosen.end(), [&](const ColumnRows& c) {
    const auto number = column_number(c.name).value_or(0);
    return number == 0 || (fields.size() >= number && fields[number - 1] == c.is);
  });
}

std::vector<Line> lines_of(std::string_view text, Delimiter delimiter, const std::vector<ColumnRows>& chosen) {
  std::vector<Line> lines;
  const bool by_number =
      std::any_of(chosen.begin(), chosen.end(), [](const ColumnRows& c) { return column_number(c.name).has_value(); });
  // Of chosen rows those bytes count alone: the others may fill the beginning.
  TextReader reader("", separator_of(delimiter), by_number ? text : text.substr(0, kLooked));
  std::size_t looked = 0;
  while (looked < kLooked && reader.next()) {
    const auto& fields = reader.fields();
    if (!are_chosen(fields, chosen) || reader.line() == kDataMark) continue;
    looked += reader.line().size();
    const bool trailing = fields.size() > 1 && fields.back().empty();
    const auto numbers = static_cast<std::size_t>(std::count_if(fields.begin(), fields.end(), [&](std::string_view f) {
      return number_in(f, separator_of(delimiter)).has_value();
    }));
    const auto empty = static_cast<std::size_t>(
        std::count_if(fields.begin(), fields.end(), [](std::string_view f) { return f.empty(); }));
    const bool time_alone = numbers == 1 && fields.size() > 2 && numbers + empty == fields.size();
    lines.push_back({reader.line_number(), fields.size(),
                     fields.size() - (trailing || begins_with_mark(fields) ? 1 : 0),
                     time_alone || (numbers >= 2 && 2 * (numbers + empty) >= fields.size()), false});
    if (!lines.back().is_row) lines.back().is_units = are_units(fields);
  }
  if (!by_number && text.size() > kLooked && !lines.empty()) lines.pop_back();  // it is cut
  return lines;
}

// How many fields most rows have. Lines that are cut have fewer.
std::size_t usual_fields(const std::vector<Line>& lines) {
  std::map<std::size_t, std::size_t> counts;
  for (const Line& line : lines) counts[line.fields] += line.is_row ? 1 : 0;
  std::size_t usual = 0, most = 0;
  for (const auto& [fields, count] : counts) {
    if (count == 0 || count < most) continue;
    usual = fields;
    most = count;
  }
  return usual;
}

// The layout with this delimiter, and the number of fields.
std::optional<std::pair<TextLayout, std::size_t>> layout_with(std::string_view text, Delimiter delimiter,
                                                              const ColumnMap& given) {
  const std::vector<Line> lines = lines_of(text, delimiter, given.rows);
  std::size_t first = 0;
  if (given.skip) {
    while (first < lines.size() && lines[first].number <= *given.skip) ++first;
    if (given.header.value_or(first < lines.size() && !lines[first].is_row)) ++first;
    while (first < lines.size() && lines[first].is_units) ++first;
  } else {
    const std::size_t usual = usual_fields(lines);
    while (first < lines.size() && !(lines[first].is_row && lines[first].fields == usual)) ++first;
  }
  if (first >= lines.size()) return std::nullopt;
  const Line& row = lines[first];
  TextLayout layout{delimiter, 0, 0, row.number, row.whole};
  std::size_t header = first;  // the line below it
  // Below the names there may stand a line of units, and below that one more, such as of the sensors.
  const auto is_above = [&](std::size_t i) {
    const Line& above = lines[i];
    const bool alike = above.whole == row.whole || above.whole == row.fields || above.fields == row.fields;
    return above.number > given.skip.value_or(0) && given.header.value_or(!above.is_row && alike);
  };
  for (std::size_t i = first; i > 1 && is_above(i - 1) && is_above(i - 2); --i) {
    if (!lines[i - 1].is_units) continue;
    layout.units = lines[i - 1].number;
    header = i - 1;
    break;
  }
  if (header > 0 && is_above(header - 1)) layout.header = lines[header - 1].number;
  return std::pair{layout, row.fields};
}

}  // namespace

std::optional<std::size_t> column_number(std::string_view name) {
  std::size_t number = 0;
  const auto [end, error] = std::from_chars(name.data(), name.data() + name.size(), number);
  if (error != std::errc{} || end != name.data() + name.size() || number == 0) return std::nullopt;
  return number;
}

TextReader::Separator separator_of(Delimiter delimiter) {
  switch (delimiter) {
    case Delimiter::kComma:
      return TextReader::Separator::kComma;
    case Delimiter::kSemicolon:
      return TextReader::Separator::kSemicolon;
    case Delimiter::kTab:
      return TextReader::Separator::kTab;
    case Delimiter::kBlanks:
      break;
  }
  return TextReader::Separator::kSpaces;
}

std::optional<TextLayout> find_layout(std::string_view text, const ColumnMap& given) {
  std::optional<TextLayout> best;
  std::size_t most = 0;
  for (const Delimiter delimiter : {Delimiter::kSemicolon, Delimiter::kTab, Delimiter::kComma, Delimiter::kBlanks}) {
    if (given.delimiter.value_or(delimiter) != delimiter) continue;
    constexpr std::size_t kEnough = 3;  // with so many fields blanks stand within them, as in calendar times
    if (delimiter == Delimiter::kBlanks && most >= kEnough) continue;
    const auto found = layout_with(text, delimiter, given);
    if (!found || found->second <= most) continue;
    best = found->first;
    most = found->second;
  }
  return best;
}

std::vector<HeaderCell> header_cells(const std::vector<std::string_view>& fields, std::size_t columns) {
  std::vector<HeaderCell> cells;
  const bool mark_alone = begins_with_mark(fields) && fields.size() > columns;
  for (std::size_t i = mark_alone ? 1 : 0; i < fields.size(); ++i) {
    std::string_view whole = without(fields[i], " \t\"");
    if (i == 0) whole = without(whole.substr(std::min(whole.find_first_not_of(kMarks), whole.size())), " \t\"");
    HeaderCell cell{std::string(whole), std::string(whole), {}};
    constexpr std::array<std::pair<char, char>, 2> kBrackets{{{'[', ']'}, {'(', ')'}}};
    for (const auto& [open, close] : kBrackets) {
      const auto at = whole.find(open);
      if (at == std::string_view::npos || at == 0 || !whole.ends_with(close)) continue;
      cell.name = without(whole.substr(0, at), " \t_");
      cell.unit = without(whole.substr(at + 1, whole.size() - at - 2), " \t");
      break;
    }
    cells.push_back(std::move(cell));
  }
  return cells;
}

void add_units(std::vector<HeaderCell>& cells, const std::vector<std::string_view>& fields) {
  for (std::size_t i = 0; i < std::min(cells.size(), fields.size()); ++i) {
    if (cells[i].unit.empty()) cells[i].unit = bare(fields[i]);
  }
}

}  // namespace piste
