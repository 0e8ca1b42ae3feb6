#include "column_table.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <limits>

namespace piste {
namespace {

constexpr std::size_t kFirst = 3000, kLater = 1500;  // rows of the first stretch, and of each of the others
constexpr std::size_t kParts = 4;                    // of the file, one stretch each

// How names and brackets spell units, beside the units themselves: their words, and the unit.
struct Spelling {
  std::string_view words, unit;
};
constexpr std::array kSpellings = std::to_array<Spelling>(
    {{"rad", "rad"},        {"radian", "rad"},    {"radians", "rad"},     {"mrad", "mrad"},
     {"deg", "deg"},        {"degree", "deg"},    {"degrees", "deg"},     {"m", "m"},
     {"meter", "m"},        {"meters", "m"},      {"metre", "m"},         {"metres", "m"},
     {"mm", "mm"},          {"cm", "cm"},         {"km", "km"},           {"ft", "0.3048 m"},
     {"foot", "0.3048 m"},  {"feet", "0.3048 m"}, {"m s", "m/s"},         {"mps", "m/s"},
     {"mm s", "mm/s"},      {"cm s", "cm/s"},     {"km h", "km/h"},       {"kmh", "km/h"},
     {"kph", "km/h"},       {"kn", "kn"},         {"kt", "kn"},           {"kts", "kn"},
     {"knot", "kn"},        {"knots", "kn"},      {"mph", "0.44704 m/s"}, {"ft s", "0.3048 m/s"},
     {"fps", "0.3048 m/s"}, {"rad s", "rad/s"},   {"rads", "rad/s"},      {"radps", "rad/s"},
     {"deg s", "deg/s"},    {"degs", "deg/s"},    {"degps", "deg/s"},     {"dps", "deg/s"},
     {"mdps", "mdeg/s"},    {"m s 2", "m/s^2"},   {"m s s", "m/s^2"},     {"ms 2", "m/s^2"},
     {"mps 2", "m/s^2"},    {"g", "g"},           {"mg", "mg"},           {"s", "s"},
     {"ms", "ms"},          {"us", "us"},         {"ns", "ns"},           {"u t", "uT"},
     {"ut", "uT"}});

// Takes the unit off the end of a column's name: the longest that still leaves a name.
void take_unit(SampledColumn& column) {
  constexpr std::size_t kLongest = 3;  // words
  std::vector<std::string>& words = column.words;
  for (std::size_t count = std::min(kLongest, words.size() - std::min<std::size_t>(words.size(), 1)); count > 0;
       --count) {
    column.unit = unit_spelt(std::span(words).last(count));
    if (column.unit.empty()) continue;
    words.resize(words.size() - count);
    return;
  }
}

// Parts the last word where it is a quantity and an axis, or an accuracy, in one: `gyrox`, `veln`, `hacc`.
void part_words(SampledColumn& column) {
  constexpr std::array<std::string_view, 9> kOfAxes{"gyro",  "gyr", "acc",       "accel",        "mag",
                                                    "omega", "vel", "gyroscope", "accelerometer"};
  if (column.words.empty()) return;
  const std::string last = column.words.back();
  if (last.size() < 4) return;
  const std::string stem = last.substr(0, last.size() - 1);
  const bool axis = std::string_view(stem == "vel" ? "nedu" : "xyz").find(last.back()) != std::string_view::npos;
  if (axis && std::find(kOfAxes.begin(), kOfAxes.end(), stem) != kOfAxes.end()) {
    column.words.back() = stem;
    column.words.emplace_back(1, last.back());
  } else if (last == "hacc" || last == "vacc" || last == "sacc") {
    column.words.back() = last.substr(0, 1);
    column.words.emplace_back("acc");
  }
}

// Fields of an array stand for the axes where there are three, as of PX4's gyro_rad[0].
void take_index(SampledColumn& column) {
  constexpr std::array<std::string_view, 3> kIndices{"0", "1", "2"}, kAxes{"x", "y", "z"};
  for (std::size_t i = 0; i < kIndices.size(); ++i) {
    if (column.cell.unit == kIndices[i]) column.words.emplace_back(kAxes[i]);
  }
}

}  // namespace

std::string unit_spelt(std::span<const std::string> words) {
  const std::string all = fmt::format("{}", fmt::join(words, " "));
  const auto* const found =
      std::find_if(kSpellings.begin(), kSpellings.end(), [&](const Spelling& s) { return s.words == all; });
  return found == kSpellings.end() ? std::string() : std::string(found->unit);
}

bool SampledColumn::has(std::string_view word) const {
  return std::find(words.begin(), words.end(), word) != words.end();
}

bool SampledColumn::has_any(std::initializer_list<std::string_view> any) const {
  return std::any_of(any.begin(), any.end(), [this](std::string_view word) { return has(word); });
}

bool SampledColumn::is_whole() const {
  return std::all_of(values.begin(), values.end(), [](double v) { return !std::isfinite(v) || v == std::floor(v); });
}

std::vector<std::string> words_of(std::string_view name) {
  std::vector<std::string> words;
  const auto kind = [](char c) {
    const auto u = static_cast<unsigned char>(c);
    return std::isupper(u) != 0 ? 'A' : std::islower(u) != 0 ? 'a' : std::isdigit(u) != 0 ? '0' : ' ';
  };
  char before = ' ';
  for (std::size_t i = 0; i < name.size(); ++i) {
    const char now = kind(name[i]), after = i + 1 < name.size() ? kind(name[i + 1]) : ' ';
    if (now != ' ') {
      const bool joined = now == before || (before == 'A' && now == 'a' && !words.back().empty());
      const bool last_capital = now == 'A' && before == 'A' && after == 'a';  // the T of GNSSTime
      if (!joined || last_capital) words.emplace_back();
      words.back() += static_cast<char>(std::tolower(static_cast<unsigned char>(name[i])));
    }
    before = now;
  }
  return words;
}

std::string ColumnTable::name_of(std::size_t column) const {
  const HeaderCell& cell = columns[column].cell;
  const auto count = [&](auto HeaderCell::*part, const std::string& name) {
    return std::count_if(columns.begin(), columns.end(), [&](const SampledColumn& c) { return c.cell.*part == name; });
  };
  if (!header || cell.whole.empty()) return fmt::format("{}", column + 1);
  const bool plain = !cell.name.empty() && count(&HeaderCell::name, cell.name) == 1;
  if (plain) return cell.name;
  return count(&HeaderCell::whole, cell.whole) == 1 ? cell.whole : fmt::format("{}", column + 1);
}

bool ColumnTable::begins(std::size_t row) const {
  return std::find(stretches.begin(), stretches.end(), row) != stretches.end();
}

std::optional<ColumnTable> sample_columns(std::string_view text) {
  const auto layout = find_layout(text, {});
  if (!layout) return std::nullopt;
  const auto separator = separator_of(layout->delimiter);
  ColumnTable table;
  TextReader reader("", separator, text);
  while (reader.next() && reader.line_number() < layout->rows) {
    if (reader.line_number() != layout->header) continue;
    for (HeaderCell& cell : header_cells(reader.fields()))
      table.columns.push_back({std::move(cell), {}, {}, {}, {}, {}});
  }
  table.header = layout->header != 0;
  if (table.header && table.columns.back().cell.whole.empty()) table.columns.pop_back();
  if (!table.header) {
    std::size_t count = reader.fields().size();
    if (count > 1 && reader.fields().back().empty()) --count;
    table.columns.resize(count);
  }
  for (std::size_t i = 0; i < table.columns.size(); ++i) {
    SampledColumn& column = table.columns[i];
    column.words = words_of(column.cell.name);
    take_unit(column);
    part_words(column);
    take_index(column);
    if (i < reader.fields().size()) column.first = reader.fields()[i];
  }
  const auto take = [&](TextReader& rows, std::size_t most, bool more) {
    table.stretches.push_back(table.rows);
    for (std::size_t i = 0; i < most && more; ++i, more = rows.next()) {
      const auto& fields = rows.fields();
      if (fields.size() != table.columns.size() && fields.size() != table.columns.size() + 1) continue;
      for (std::size_t c = 0; c < table.columns.size(); ++c) {
        table.columns[c].values.push_back(
            number_in(fields[c], separator).value_or(std::numeric_limits<double>::quiet_NaN()));
        if (table.stretches.size() == 1) table.columns[c].last = fields[c];
      }
      ++table.rows;
    }
  };
  take(reader, kFirst, true);
  const std::string_view rest = reader.rest();
  for (std::size_t part = 1; part < kParts; ++part) {
    const std::size_t line = rest.find('\n', part * rest.size() / kParts);
    if (line == std::string_view::npos) break;
    TextReader later("", separator, rest.substr(line + 1, rest.size() / kParts - 1));
    take(later, kLater, later.next());
  }
  return table;
}

}  // namespace piste
