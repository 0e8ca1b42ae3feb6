#include "report/drawing.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <span>
#include <utility>

#include "plot/markup.h"
#include "plot/svg_frame.h"
#include "report/packed_table.h"
#include "report/page.h"

namespace piste::page {
namespace {

constexpr std::size_t kMostRows = 40'000;  // of a curve; a longer one is an envelope, or with a band every n-th row
constexpr double kPlaces = 1e9;            // of an axis: rows of curves that stand at one place stay so
constexpr double kStepsOfRange = 1e6;      // numbers of a table are exact to half of such a part of their range

// `speed [m/s]` → speed, m/s.
std::pair<std::string, std::string> label_and_unit(const std::string& text) {
  const std::size_t open = text.rfind('[');
  if (open == std::string::npos || !text.ends_with(']')) return {text, ""};
  std::string label = text.substr(0, open);
  while (label.ends_with(' ')) label.pop_back();
  return {label, text.substr(open + 1, text.size() - open - 2)};
}

bool is_curve(const Plot& plot) {
  return plot.x().names.empty() && plot.y().names.empty() && !plot.is_map() &&
         std::ranges::none_of(plot.series(), [](const Plot::Series& s) { return s.kind == Plot::Kind::kBarsAlongX; });
}

// Least and largest of finite values.
struct Reach {
  double low = INFINITY, high = -INFINITY, least_size = INFINITY;
  void add(std::span<const double> values) {
    for (const double v : values) {
      if (!std::isfinite(v)) continue;
      low = std::min(low, v);
      high = std::max(high, v);
      if (v != 0) least_size = std::min(least_size, std::abs(v));
    }
  }
  bool any() const { return low <= high; }
};

// Of a logarithmic axis the step is a part of the least value.
double step_of(std::span<const std::vector<double>> columns, bool log) {
  constexpr double kPartOfLeast = 1e-4, kFinest = 1e-15;
  Reach reach;
  for (const std::vector<double>& column : columns) reach.add(column);
  if (!reach.any()) return 1;
  const double largest = std::max(std::abs(reach.low), std::abs(reach.high)), range = reach.high - reach.low;
  const double step = log && std::isfinite(reach.least_size) ? kPartOfLeast * reach.least_size
                                                             : (range > 0 ? range : largest) / kStepsOfRange;
  return std::max({step, kFinest, kFinest * largest});
}

double on_axis(double x, bool log) { return log ? std::log10(x) : x; }

// The rows of a series that can be drawn on the axis, in its order.
struct Rows {
  std::vector<double> x;
  std::array<std::vector<double>, 3> columns;  // value, low, high; the latter may be empty
};

Rows rows_of(const Plot::Series& s, const Plot& plot) {
  const bool banded = !s.low.empty();
  const std::size_t every = banded ? 1 + s.x.size() / kMostRows : 1;
  std::vector<std::pair<double, std::size_t>> order;
  for (std::size_t i = 0; i < s.x.size(); i += every) {
    const double x = on_axis(s.x[i], plot.x().log);
    if (std::isfinite(x)) order.emplace_back(x, i);
  }
  std::ranges::stable_sort(order, {}, &std::pair<double, std::size_t>::first);
  Rows out;
  const auto shown = [&](double v) { return plot.y().log && !(v > 0) ? NAN : v; };
  for (const auto& [x, i] : order) {
    out.x.push_back(x);
    out.columns[0].push_back(shown(s.y.empty() ? (s.low[i] + s.high[i]) / 2 : s.y[i]));
    if (!banded) continue;
    out.columns[1].push_back(shown(s.low[i]));
    out.columns[2].push_back(shown(s.high[i]));
  }
  return out;
}

// The table of a curve, and whether it has a band.
std::pair<std::string, bool> packed(const Rows& rows, double x_step, bool log) {
  const bool banded = !rows.columns[1].empty();
  if (!banded && rows.x.size() > kMostRows) {
    std::vector<std::size_t> there;
    for (std::size_t i = 0; i < rows.x.size(); ++i) {
      if (std::isfinite(rows.columns[0][i])) there.push_back(i);
    }
    Envelope envelope({"value"}, there.size());
    for (const std::size_t i : there) envelope.add(rows.x[i], {&rows.columns[0][i], 1});
    const bool extremes = envelope.has_extremes();
    return {envelope.json(), extremes};
  }
  PackedTable table;
  table.add("x", rows.x, x_step);
  const double step = step_of(rows.columns, log);
  constexpr std::array kNames{"value", "value_least", "value_most"};
  for (std::size_t k = 0; k < (banded ? 3 : 1); ++k) table.add(kNames[k], rows.columns[k], step);
  return {table.json(), banded};
}

std::string stroke_of(const Plot::Series& s) {
  if (s.kind == Plot::Kind::kBand) return "none";
  if (s.kind != Plot::Kind::kLine) return "dots";
  return s.stroke == Plot::Stroke::kDashed ? "dashed" : s.stroke == Plot::Stroke::kDotted ? "dotted" : "";
}

// The series with bands joined to the lines that they are of, and marks as single dots.
std::vector<Plot::Series> curves_of(const Plot& plot) {
  std::vector<Plot::Series> out;
  for (const Plot::Series& s : plot.series()) {
    if (s.kind == Plot::Kind::kShade) continue;
    const auto band = std::ranges::find_if(out, [&](const Plot::Series& before) {
      return before.kind == Plot::Kind::kBand && s.kind == Plot::Kind::kLine && before.colour == s.colour &&
             before.x == s.x;
    });
    if (band == out.end()) {
      out.push_back(s);
      continue;
    }
    Plot::Series joined = s;
    joined.low = std::move(band->low);
    joined.high = std::move(band->high);
    *band = std::move(joined);
  }
  for (const Plot::Mark& m : plot.marks()) {
    out.push_back({Plot::Kind::kPoints, {m.x}, {m.y}, {}, {}, m.colour, m.name});
  }
  return out;
}

// Names of curves are different, as the library asks.
std::string name_among(const std::vector<Curve>& others, std::string wanted) {
  const auto taken = [&](const std::string& name) {
    return std::ranges::any_of(others, [&](const Curve& c) { return c.label == name; });
  };
  std::string name = wanted;
  for (int k = 2; taken(name); ++k) name = fmt::format("{} {}", wanted, k);
  return name;
}

std::vector<Shade> shades_of(const Plot& plot) {
  constexpr int kMoving = 4;  // the colour in which figures shade what is not at rest
  std::vector<Shade> out;
  for (const Plot::Series& s : plot.series()) {
    if (s.kind != Plot::Kind::kShade) continue;
    out.push_back({s.x[0], s.x[1], s.colour == kMoving ? "turn" : "rest"});
  }
  return out;
}

constexpr double kRoomForDots = 0.02;  // of the axis, at either end

bool has_dots(const Plot& plot) {
  return std::ranges::any_of(plot.series(), [](const Plot::Series& s) {
    return s.kind == Plot::Kind::kPoints || s.kind == Plot::Kind::kBarsAlongY;
  });
}

}  // namespace

std::string Drawing::head() const { return data_.charts.empty() ? "" : tools(false); }

std::string Drawing::style() const { return data_.charts.empty() ? "" : styles(); }

std::string Drawing::scripts() const { return data_.charts.empty() ? "" : page::scripts(data_); }

std::string Drawing::axis_of(const Plot& plot) {
  const auto [label, unit] = label_and_unit(plot.x().label);
  Reach reach;
  for (const Plot::Series& s : plot.series()) {
    if (s.kind == Plot::Kind::kShade) continue;
    for (const double x : s.x) reach.add(std::array{on_axis(x, plot.x().log)});
  }
  if (const auto& limit = plot.x_limit()) {
    reach.low = on_axis((*limit)[0], plot.x().log);
    reach.high = on_axis((*limit)[1], plot.x().log);
  }
  if (!reach.any()) return {};
  if (const double room = kRoomForDots * (reach.high - reach.low); has_dots(plot))
    reach.low -= room, reach.high += room;
  const std::vector<Shade> shades = shades_of(plot);
  const double apart = 1e-6 * (reach.high - reach.low);
  for (const Axis& a : data_.axes) {
    if (a.label == label && a.unit == unit && a.log == plot.x().log && std::abs(a.start - reach.low) <= apart &&
        std::abs(a.end - reach.high) <= apart && a.shades.size() == shades.size()) {
      return a.name;
    }
  }
  std::string name = fmt::format("axis_{}", data_.axes.size() + 1);
  const double step = (reach.high - reach.low) / kPlaces;  // rounding leaves no row outside
  data_.axes.push_back({name, label, unit, plot.x().log, reach.low - step, reach.high + step, shades});
  return name;
}

std::string Drawing::chart_of(const Figure& figure) {
  const Plot& plot = *figure.plot;
  const auto [label, unit] = label_and_unit(plot.y().label);
  Chart chart{.name = figure.name,
              .title = plot.title(),
              .unit = unit,
              .group = "",
              .table = "",
              .curves = {},
              .log = plot.y().log,
              .axis = axis_of(plot),
              .limits = plot.y_limit()};
  if (chart.axis.empty()) return {};
  const auto axis = std::ranges::find(data_.axes, chart.axis, &Axis::name);
  const double x_step = axis->end > axis->start ? (axis->end - axis->start) / kPlaces : 1;
  for (const Plot::Series& s : curves_of(plot)) {
    const auto [table, banded] = packed(rows_of(s, plot), x_step, plot.y().log);
    Curve curve{.label = name_among(chart.curves, s.label.empty() ? (label.empty() ? "value" : label) : s.label),
                .value = "value",
                .table = fmt::format("{}/{}", figure.name, chart.curves.size()),
                .stroke = stroke_of(s),
                .colour = s.colour};
    if (banded) curve.low = "value_least", curve.high = "value_most";
    data_.tables.emplace_back(curve.table, table);
    if (chart.table.empty()) chart.table = curve.table;
    chart.curves.push_back(std::move(curve));
  }
  if (chart.curves.empty()) return {};
  data_.charts.push_back(std::move(chart));
  return place(figure.name);
}

std::string Drawing::add_map(const Figure& map, const Plot& over, const std::vector<Path>& paths) {
  constexpr double kPixelStep = 0.05;
  const std::string axis = draws() && map.plot ? axis_of(over) : "";
  if (axis.empty()) return pictures({map});
  const auto found = std::ranges::find(data_.axes, axis, &Axis::name);
  const double x_step = (found->end - found->start) / kPlaces;
  Places places{map.name, axis};
  for (const Path& path : paths) {
    std::vector<double> right, down;
    for (std::size_t i = 0; i < path.x.size(); ++i) {
      const auto at = map.plot->pixel(path.east[i], path.north[i]);
      right.push_back(at[0]);
      down.push_back(at[1]);
    }
    PackedTable table;
    table.add("x", path.x, x_step);
    table.add("right", right, kPixelStep);
    table.add("down", down, kPixelStep);
    places.lines.push_back({fmt::format("{}/{}", map.name, places.lines.size()), path.colour});
    data_.tables.emplace_back(places.lines.back().table, table.json());
  }
  data_.places.push_back(std::move(places));
  return fmt::format("<div data-places=\"{}\">\n{}</div>\n", map.name, pictures({map}));
}

std::string Drawing::add(const std::vector<Figure>& figures) {
  if (figures.empty()) return pictures(figures);
  std::string out, charts;  // charts that follow one another stand side by side
  const auto close = [&] {
    if (!charts.empty()) out += fmt::format("<div class=\"charts\">\n{}</div>\n", std::exchange(charts, ""));
  };
  for (const Figure& f : figures) {
    const std::string chart = draws() && f.plot && is_curve(*f.plot) ? chart_of(f) : "";
    if (chart.empty()) {
      close();
      out += pictures({f});
      continue;
    }
    charts += "<figure>\n" + chart;
    if (!f.caption.empty()) charts += fmt::format("<figcaption>{}</figcaption>\n", escape_markup(f.caption));
    charts += "</figure>\n";
  }
  close();
  return out;
}

}  // namespace piste::page
