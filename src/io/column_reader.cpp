#include "io/column_reader.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "piste/core/error.h"
#include "piste/io/config.h"

namespace piste::log_formats {
namespace {

// What rows are chosen, in words.
std::string chosen_text(const std::vector<ColumnRows>& rows) {
  std::vector<std::string> all;
  all.reserve(rows.size());
  for (const ColumnRows& r : rows) all.push_back(fmt::format("`{}` in column `{}`", r.is, r.name));
  return fmt::format("{}", fmt::join(all, " and "));
}

TextLayout require_layout(const std::string& file, const ColumnMap& map, std::string_view text) {
  if (const auto layout = find_layout(text, map)) return *layout;
  if (!map.rows.empty()) {
    throw DataError(file + ":1",
                    fmt::format("no rows of numbers with {} are found; `rows` names the column and the text "
                                "that the rows of one sensor have",
                                chosen_text(map.rows)));
  }
  throw DataError(file + ":1",
                  "no rows of numbers are found; with `delimiter`, `skip` (lines above the header) and `header: false` "
                  "a configuration says how the file is laid out");
}

}  // namespace

ColumnReader::ColumnReader(const std::string& file, const ColumnMap& map, std::optional<std::string_view> content)
    : text_(file, TextReader::Separator::kComma, content) {
  const TextLayout layout = require_layout(file, map, text_.rest());
  text_.set_separator(separator_of(layout.delimiter));
  header_ = layout.header;
  while (text_.next() && text_.line_number() < layout.rows) {
    if (text_.line_number() == header_) cells_ = header_cells(text_.fields(), layout.columns);
    if (text_.line_number() == layout.units) add_units(cells_, text_.fields());
  }
  at_row_ = true;
  fields_ = header_ != 0 ? cells_.size() : text_.fields().size();
  const bool trailing = fields_ > 1 && (header_ != 0 ? cells_.back().whole.empty() : text_.fields().back().empty());
  if (trailing) --fields_;
  cells_.resize(header_ != 0 ? fields_ : 0);
  chosen_.reserve(map.rows.size());
  for (const ColumnRows& rows : map.rows) chosen_.push_back({place_of(rows.name, "rows"), rows});
}

// Whether the present row is of the sensor. A row that is cut before that field is reported as cut.
bool ColumnReader::is_chosen() const {
  const auto& found = text_.fields();
  return std::all_of(chosen_.begin(), chosen_.end(), [&](const Chosen& c) {
    return found.size() <= c.place ? !cells_.empty() : found[c.place] == c.rows.is;
  });
}

std::size_t ColumnReader::place_of(const std::string& name, std::string_view key) const {
  const std::string where = fmt::format("{}:{}", text_.file(), std::max<std::size_t>(header_, 1));
  const auto place = [&](auto&& is_it) -> std::optional<std::size_t> {
    const auto found = std::find_if(cells_.begin(), cells_.end(), is_it);
    if (found == cells_.end()) return std::nullopt;
    if (std::find_if(found + 1, cells_.end(), is_it) != cells_.end()) {
      throw DataError(where,
                      fmt::format("column `{}` of `{}` stands twice; give the header's whole cell, or number the "
                                  "columns with `header: false`",
                                  name, key));
    }
    return static_cast<std::size_t>(found - cells_.begin());
  };
  if (const auto found = place([&](const HeaderCell& c) { return c.whole == name; })) return *found;
  if (const auto found = place([&](const HeaderCell& c) { return c.name == name; })) return *found;
  if (const auto number = column_number(name); number && *number <= fields_) return *number - 1;
  if (cells_.empty()) {
    throw DataError(where, fmt::format("there is no column `{}` of `{}`: the file has no header, and its columns have "
                                       "the numbers 1 to {}",
                                       name, key, fields_));
  }
  std::vector<std::string> names, whole;
  for (const HeaderCell& c : cells_) {
    names.push_back(c.name);
    whole.push_back(c.whole);
  }
  const auto near = nearest_spelling(name, names);
  throw DataError(where, fmt::format("there is no column `{}` of `{}`{}; the columns are: {}", name, key,
                                     near ? fmt::format(", perhaps `{}`", *near) : "", fmt::join(whole, ", ")));
}

Column ColumnReader::column(const std::string& name, std::string_view key, const std::string& unit,
                            const Dimension& dimension) const {
  const std::size_t index = place_of(name, key);
  const std::string& stated = unit.empty() && !cells_.empty() ? cells_[index].unit : unit;
  const std::string where = fmt::format("{}:{}", text_.file(), std::max<std::size_t>(header_, 1));
  if (stated.empty() && !(dimension == dimension::kRatio)) {
    throw DataError(where, fmt::format("column `{}` of `{}` has no unit in the header; give it in the configuration: "
                                       "`unit: …` of {}, such as that of `{}`",
                                       name, key, dimension.name, dimension.example));
  }
  try {
    return {index, unit_factor(stated, dimension)};
  } catch (const std::invalid_argument& e) {
    throw DataError(where, fmt::format("column `{}` of `{}`: {}; `unit: …` in the configuration replaces the header's",
                                       name, key, e.what()));
  }
}

std::vector<Column> ColumnReader::columns(const ColumnMap& map, const ColumnQuantity& quantity) const {
  std::vector<Column> found;
  if (const ColumnUse* use = map.find(quantity.key)) {
    for (const std::string& name : use->names) {
      if (use->unit == kDegreesMinutes) {
        found.push_back({place_of(name, quantity.key), kDegree});
      } else {
        found.push_back(column(name, quantity.key, use->unit, quantity.dimension));
      }
    }
  }
  return found;
}

void ColumnReader::fail_without_rows() const {
  std::vector<ColumnRows> rows;
  rows.reserve(chosen_.size());
  for (const Chosen& c : chosen_) rows.push_back(c.rows);
  throw DataError(fmt::format("{}:{}", text_.file(), std::max<std::size_t>(header_, 1)),
                  fmt::format("no row has {}, as `rows` has it", chosen_text(rows)));
}

bool ColumnReader::next() {
  do {
    if (!at_row_ && !text_.next()) {
      if (!any_ && !chosen_.empty()) fail_without_rows();
      return false;
    }
    at_row_ = false;
  } while (!is_chosen());
  any_ = true;
  const auto& found = text_.fields();
  const bool trailing = found.size() == fields_ + 1 && found.back().empty();
  if (found.size() != fields_ && !trailing) {
    text_.fail(fmt::format("{} fields, but {} columns are {}; is the line cut?", found.size(), fields_,
                           cells_.empty() ? "in the first row" : "named"),
               RowFault::Kind::kFields);
  }
  return true;
}

double ColumnReader::value(const Column& column) const {
  const double value = column.factor * text_.number(column.index);
  if (!std::isfinite(value)) text_.fail("a value is not finite in SI units", RowFault::Kind::kNotFinite);
  return value;
}

bool ColumnReader::has_value(const Column& column) const {
  const std::string_view text = text_.fields()[column.index];
  for (const std::string_view none : {"", "nan", "NaN", "NAN", "null", "NULL", "NA", "N/A", "-"}) {
    if (text == none) return false;
  }
  return true;
}

std::optional<double> ColumnReader::find_value(const Column& column) const {
  return has_value(column) ? std::optional(value(column)) : std::nullopt;
}

}  // namespace piste::log_formats
