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

// Spellings of units in names and brackets, in addition to the units themselves: their words, and the unit.
struct Spelling {
  std::string_view words, unit;
};
constexpr std::array kSpellings = std::to_array<Spelling>({{"rad", "rad"},
                                                           {"radian", "rad"},
                                                           {"radians", "rad"},
                                                           {"mrad", "mrad"},
                                                           {"deg", "deg"},
                                                           {"degree", "deg"},
                                                           {"degrees", "deg"},
                                                           {"m", "m"},
                                                           {"meter", "m"},
                                                           {"meters", "m"},
                                                           {"metre", "m"},
                                                           {"metres", "m"},
                                                           {"mm", "mm"},
                                                           {"cm", "cm"},
                                                           {"km", "km"},
                                                           {"ft", "0.3048 m"},
                                                           {"foot", "0.3048 m"},
                                                           {"feet", "0.3048 m"},
                                                           {"m s", "m/s"},
                                                           {"mps", "m/s"},
                                                           {"mm s", "mm/s"},
                                                           {"cm s", "cm/s"},
                                                           {"km h", "km/h"},
                                                           {"kmh", "km/h"},
                                                           {"kph", "km/h"},
                                                           {"kmph", "km/h"},
                                                           {"kn", "kn"},
                                                           {"kt", "kn"},
                                                           {"kts", "kn"},
                                                           {"knot", "kn"},
                                                           {"knots", "kn"},
                                                           {"mph", "0.44704 m/s"},
                                                           {"ft s", "0.3048 m/s"},
                                                           {"fps", "0.3048 m/s"},
                                                           {"rad s", "rad/s"},
                                                           {"rads", "rad/s"},
                                                           {"radps", "rad/s"},
                                                           {"deg s", "deg/s"},
                                                           {"degs", "deg/s"},
                                                           {"degps", "deg/s"},
                                                           {"dps", "deg/s"},
                                                           {"mdps", "mdeg/s"},
                                                           {"m s 2", "m/s^2"},
                                                           {"m s s", "m/s^2"},
                                                           {"ms 2", "m/s^2"},
                                                           {"mps 2", "m/s^2"},
                                                           {"g", "g"},
                                                           {"mg", "mg"},
                                                           {"s", "s"},
                                                           {"ms", "ms"},
                                                           {"us", "us"},
                                                           {"ns", "ns"},
                                                           {"u t", "uT"},
                                                           {"ut", "uT"},
                                                           {"rad per sec", "rad/s"},
                                                           {"deg per sec", "deg/s"}});

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
  if (last == "yawrate" || last == "pitchrate" || last == "rollrate") {
    constexpr std::size_t kRate = 4;
    column.words.back() = last.substr(0, last.size() - kRate);
    column.words.emplace_back("rate");
    return;
  }
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

// Puts the axis that a name begins with at its end: `X Accel`, `x_rate_of_rotation`, `x-axis`.
void turn_words(SampledColumn& column) {
  std::vector<std::string>& words = column.words;
  const auto is_axis = [](const std::string& word) { return word == "x" || word == "y" || word == "z"; };
  std::erase(words, "axis");
  if (words.size() > 1 && words.back() == "cal") words.pop_back();  // calibrated, of Shimmer
  if (words.size() > 1 && is_axis(words.front()) && !is_axis(words.back()))
    std::rotate(words.begin(), words.begin() + 1, words.end());
}

// Columns of numbers as names, behind one of a sensor, are its other axes: `Accelerometer [m/s2],1,2` of GoPro.
void take_followers(std::vector<SampledColumn>& columns) {
  for (std::size_t i = 0; i + 2 < columns.size(); ++i) {
    const std::vector<std::string> words = columns[i].words;
    if (words.empty() || columns[i + 1].words != std::vector<std::string>{"1"} ||
        columns[i + 2].words != std::vector<std::string>{"2"})
      continue;
    constexpr std::array<std::string_view, 3> kAxes{"x", "y", "z"};
    for (std::size_t k = 0; k < kAxes.size(); ++k) {
      columns[i + k].words = words;
      columns[i + k].words.emplace_back(kAxes[k]);
    }
  }
}

// The reference surface of a height, if in brackets: `Alt (HAE)`.
void take_height_kind(SampledColumn& column) {
  for (std::string& word : words_of(column.cell.unit)) {
    if (word == "hae" || word == "msl" || word == "ellipsoid") column.words.push_back(std::move(word));
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

std::string_view SampledColumn::first() const {
  const auto found = std::find_if(texts.begin(), texts.end(), [](std::string_view text) { return !text.empty(); });
  return found == texts.end() ? std::string_view() : *found;
}

std::string_view SampledColumn::last() const {
  const auto found = std::find_if(texts.rbegin(), texts.rend(), [](std::string_view text) { return !text.empty(); });
  return found == texts.rend() ? std::string_view() : *found;
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
  if (!header || by_number || cell.whole.empty()) return fmt::format("{}", column + 1);
  const bool plain = !cell.name.empty() && count(&HeaderCell::name, cell.name) == 1;
  if (plain) return cell.name;
  return count(&HeaderCell::whole, cell.whole) == 1 ? cell.whole : fmt::format("{}", column + 1);
}

bool ColumnTable::begins(std::size_t row) const {
  return std::find(stretches.begin(), stretches.end(), row) != stretches.end();
}

ColumnTable ColumnTable::rows_where(const std::function<bool(std::size_t)>& holds) const {
  ColumnTable part;
  part.header = header;
  part.by_number = by_number;
  part.columns.reserve(columns.size());
  for (const SampledColumn& c : columns) part.columns.push_back({c.cell, c.words, c.unit, c.along, {}, {}});
  for (std::size_t row = 0; row < rows; ++row) {
    if (begins(row) && (part.stretches.empty() || part.stretches.back() != part.rows))
      part.stretches.push_back(part.rows);
    if (!holds(row)) continue;
    for (std::size_t c = 0; c < columns.size(); ++c) {
      part.columns[c].texts.push_back(columns[c].texts[row]);
      part.columns[c].values.push_back(columns[c].values[row]);
    }
    ++part.rows;
  }
  return part;
}

ColumnTable ColumnTable::rows_with(std::span<const std::size_t> which) const {
  return rows_where([&](std::size_t row) {
    return std::all_of(which.begin(), which.end(),
                       [&](std::size_t c) { return std::isfinite(columns[c].values[row]); });
  });
}

ColumnTable table_with(std::vector<HeaderCell> cells, bool by_number) {
  ColumnTable table;
  table.header = true;
  table.by_number = by_number;
  table.columns.reserve(cells.size());
  for (HeaderCell& cell : cells) table.columns.push_back({std::move(cell), {}, {}, {}, {}, {}});
  for (SampledColumn& column : table.columns) {
    column.words = words_of(column.cell.name);
    take_unit(column);
    part_words(column);
    turn_words(column);
    take_index(column);
    take_height_kind(column);
  }
  take_followers(table.columns);
  return table;
}

void sample_rows(std::string_view text, TextReader::Separator separator, ColumnTable& table,
                 const std::function<bool(const std::vector<std::string_view>&)>& is_row) {
  const auto take = [&](std::string_view part, std::size_t most) {
    TextReader rows("", separator, part);
    table.stretches.push_back(table.rows);
    const std::size_t end = table.rows + most;
    while (table.rows < end && rows.next()) {
      const auto& fields = rows.fields();
      if (!is_row(fields)) continue;
      for (std::size_t c = 0; c < table.columns.size(); ++c) {
        const std::string_view field = c < fields.size() ? fields[c] : std::string_view();
        table.columns[c].texts.push_back(field);
        table.columns[c].values.push_back(
            number_in(field, separator).value_or(std::numeric_limits<double>::quiet_NaN()));
      }
      ++table.rows;
    }
    return rows.rest();
  };
  const std::string_view rest = take(text, kFirst);
  for (std::size_t part = 1; part < kParts; ++part) {
    const std::size_t line = rest.find('\n', part * rest.size() / kParts);
    if (line == std::string_view::npos) break;
    take(rest.substr(line + 1, rest.size() / kParts - 1), kLater);
  }
}

std::optional<ColumnTable> sample_columns(std::string_view text) {
  const auto layout = find_layout(text, {});
  if (!layout) return std::nullopt;
  const auto separator = separator_of(layout->delimiter);
  TextReader reader("", separator, text);
  std::vector<HeaderCell> cells;
  std::string_view rows = text;
  while (reader.line_number() + 1 < layout->rows && reader.next()) {
    if (reader.line_number() == layout->header) cells = header_cells(reader.fields(), layout->columns);
    if (reader.line_number() == layout->units) add_units(cells, reader.fields());
    rows = reader.rest();
  }
  if (!reader.next()) return std::nullopt;
  if (!cells.empty() && cells.back().whole.empty()) cells.pop_back();
  if (layout->header == 0) {
    std::size_t count = reader.fields().size();
    if (count > 1 && reader.fields().back().empty()) --count;
    cells.resize(count);
  }
  ColumnTable table = table_with(std::move(cells), false);
  table.header = layout->header != 0;
  sample_rows(rows, separator, table, [&](const auto& fields) {
    return fields.size() == table.columns.size() || fields.size() == table.columns.size() + 1;
  });
  return table;
}

}  // namespace piste
