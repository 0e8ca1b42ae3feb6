#include "plot/svg.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <memory>
#include <numeric>
#include <span>
#include <string_view>
#include <utility>

#include "plot/markup.h"
#include "plot/svg_frame.h"
#include "plot/thin.h"

namespace piste {
namespace {

constexpr double kLeft = 76, kRight = 18, kTop = 40, kBottom = 54;  // margins [px]
constexpr double kLegendRow = 20;
constexpr double kLetter = 7;  // about the width of one [px]

std::string_view dashes(Plot::Stroke stroke) {
  switch (stroke) {
    case Plot::Stroke::kSolid:
      return "";
    case Plot::Stroke::kDashed:
      return " stroke-dasharray=\"7 4\"";
    case Plot::Stroke::kDotted:
      return " stroke-dasharray=\"2 2\"";
  }
  return "";
}

std::string tick_text(double value, double step) {
  return decimal(value, std::clamp(static_cast<int>(std::ceil(-std::log10(step) - 1e-9)), 0, 12));
}

// 0.02, 5, 2·10⁻⁷.
std::string log_tick_text(double value) {
  if (value > 9e-4 && value < 9e4) return fmt::format("{:.4g}", value);
  constexpr std::array<std::string_view, 10> kRaised{"⁰", "¹", "²", "³", "⁴", "⁵", "⁶", "⁷", "⁸", "⁹"};
  const auto exponent = static_cast<int>(std::floor(std::log10(value) + 1e-9));
  const std::string leading = fmt::format("{:.3g}", value / std::pow(10, exponent));
  std::string out = leading == "1" ? "10" : leading + "·10";
  if (exponent < 0) out += "⁻";
  for (const char digit : std::to_string(std::abs(exponent))) out += kRaised[static_cast<std::size_t>(digit - '0')];
  return out;
}

double width_of(const std::string& text) { return kLetter * static_cast<double>(svg::letters(text)); }

// A whisker with its ends.
std::string whisker(double x, double low, double high, bool along_x) {
  constexpr double kEnd = 3;
  return along_x ? fmt::format("M{0:.1f} {1:.1f}H{2:.1f}M{0:.1f} {3:.1f}v{4}M{2:.1f} {3:.1f}v{4}", low, x, high,
                               x - kEnd, 2 * kEnd)
                 : fmt::format("M{1:.1f} {0:.1f}V{2:.1f}M{3:.1f} {0:.1f}h{4}M{3:.1f} {2:.1f}h{4}", low, x, high,
                               x - kEnd, 2 * kEnd);
}

}  // namespace

/// Smallest and largest value of an axis; of a logarithmic one, their logarithms.
struct Plot::Range {
  bool log = false;
  double low = std::numeric_limits<double>::infinity(), high = -std::numeric_limits<double>::infinity();

  double place(double value) const { return log ? std::log10(value) : value; }
  bool drawable(double value) const { return std::isfinite(value) && (!log || value > 0); }
  void cover(double value) {
    if (!drawable(value)) return;
    low = std::min(low, place(value));
    high = std::max(high, place(value));
  }
  void cover(const std::vector<double>& values) {
    for (const double value : values) cover(value);
  }
  /// Makes sure that the range is not empty and not a single point, and adds a little room at both ends.
  void settle() {
    if (low > high) low = 0, high = 1;
    if (high - low < 1e-12 * std::max({1.0, std::abs(low), std::abs(high)})) low -= 0.5, high += 0.5;
    const double room = 0.04 * (high - low);
    low -= room;
    high += room;
  }
  void widen_to(double length) {
    const double room = (length - (high - low)) / 2;
    low -= room;
    high += room;
  }
  double length() const { return high - low; }
};

struct Plot::Frame {
  Range x, y;
  double left, top, right, bottom;  // of the area inside the axes [px]

  double px(double value) const { return left + (x.place(value) - x.low) / x.length() * (right - left); }
  double py(double value) const { return bottom - (y.place(value) - y.low) / y.length() * (bottom - top); }
};

std::vector<double> nice_ticks(double low, double high, int wanted) {
  const double raw = (high - low) / wanted;
  const double decade = std::pow(10, std::floor(std::log10(raw)));
  const double ratio = raw / decade;
  const double step = decade * (ratio < 1.5 ? 1 : ratio < 3.5 ? 2 : ratio < 7.5 ? 5 : 10);
  std::vector<double> ticks;
  const auto first = static_cast<long long>(std::ceil(low / step - 1e-9));
  const auto last = static_cast<long long>(std::floor(high / step + 1e-9));
  for (long long k = first; k <= last; ++k) ticks.push_back(static_cast<double>(k) * step);
  return ticks;
}

std::vector<double> log_ticks(double low, double high) {
  const auto ticks = [&](const std::vector<int>& leading) {
    std::vector<double> out;
    const int last = static_cast<int>(std::floor(std::log10(high) + 1e-9));
    for (int k = static_cast<int>(std::floor(std::log10(low))); k <= last; ++k) {
      for (const int m : leading) {
        const double t = m * std::pow(10, k);
        if (t >= low * (1 - 1e-9) && t <= high * (1 + 1e-9)) out.push_back(t);
      }
    }
    return out;
  };
  std::vector<double> powers = ticks({1});
  if (powers.size() >= 3) return powers;
  std::vector<double> leading = ticks({1, 2, 5});
  return leading.size() >= 3 ? leading : nice_ticks(low, high, 5);
}

Plot::Plot(std::string title, Axis x, Axis y, std::string description)
    : title_(std::move(title)), description_(std::move(description)), x_(std::move(x)), y_(std::move(y)) {}

void Plot::line(std::vector<double> x, std::vector<double> y, int colour, std::string label, Stroke stroke) {
  series_.push_back({Kind::kLine, std::move(x), std::move(y), {}, {}, colour, std::move(label), stroke});
}

void Plot::points(std::vector<double> x, std::vector<double> y, int colour, std::string label) {
  series_.push_back({Kind::kPoints, std::move(x), std::move(y), {}, {}, colour, std::move(label)});
}

void Plot::bars(std::vector<double> x, std::vector<double> y, std::vector<double> low, std::vector<double> high,
                int colour, std::string label, Along along) {
  series_.push_back({along == Along::kX ? Kind::kBarsAlongX : Kind::kBarsAlongY, std::move(x), std::move(y),
                     std::move(low), std::move(high), colour, std::move(label)});
}

void Plot::band(std::vector<double> x, std::vector<double> low, std::vector<double> high, int colour,
                std::string label) {
  series_.push_back({Kind::kBand, std::move(x), {}, std::move(low), std::move(high), colour, std::move(label)});
}

void Plot::shade(double from, double to, int colour, std::string label) {
  series_.push_back({Kind::kShade, {from, to}, {}, {}, {}, colour, std::move(label)});
}

void Plot::mark(double x, double y, int colour, std::string name) { marks_.push_back({x, y, colour, std::move(name)}); }

void Plot::size(int width, int height) {
  width_ = width;
  height_ = height;
}

Plot::Frame Plot::frame() const {
  Frame f{{.log = x_.log}, {.log = y_.log}, kLeft, kTop, width_ - kRight, height_ - kBottom};
  if (const auto places = legend_places(); !places.empty()) f.bottom -= places.back()[1] + kLegendRow;
  for (const std::string& name : y_.names) f.left = std::max(f.left, 40 + width_of(name));
  for (const Series& s : series_) {
    f.x.cover(s.x);
    f.y.cover(s.y);
    for (const auto* ends : {&s.low, &s.high}) (s.kind == Kind::kBarsAlongX ? f.x : f.y).cover(*ends);
  }
  for (const Mark& m : marks_) {
    f.x.cover(m.x);
    f.y.cover(m.y);
  }
  f.x.settle();
  f.y.settle();
  // A name stands in the middle of its part of the axis; names of y go downwards.
  if (!x_.names.empty()) f.x.low = -0.5, f.x.high = static_cast<double>(x_.names.size()) - 0.5;
  if (!y_.names.empty()) f.y.high = -0.5, f.y.low = static_cast<double>(y_.names.size()) - 0.5;
  if (x_limit_) f.x.low = f.x.place((*x_limit_)[0]), f.x.high = f.x.place((*x_limit_)[1]);
  if (y_limit_) f.y.low = f.y.place((*y_limit_)[0]), f.y.high = f.y.place((*y_limit_)[1]);
  if (equal_scale_) {
    const double scale = std::max(f.x.length() / (f.right - f.left), f.y.length() / (f.bottom - f.top));
    f.x.widen_to(scale * (f.right - f.left));
    f.y.widen_to(scale * (f.bottom - f.top));
  }
  return f;
}

std::array<double, 2> Plot::pixel(double x, double y) const {
  const Frame f = frame();
  return {f.px(x), f.py(y)};
}

std::string Plot::axes(const Frame& f) const {
  const auto ticks_of = [](const Axis& axis, const Range& range, double wanted) {
    if (!axis.ticks.empty()) return axis.ticks;
    if (!axis.names.empty()) {
      std::vector<double> ticks(axis.names.size());
      std::iota(ticks.begin(), ticks.end(), 0.0);
      return ticks;
    }
    return axis.log ? log_ticks(std::pow(10, range.low), std::pow(10, range.high))
                    : nice_ticks(range.low, range.high, std::max(1, static_cast<int>(wanted)));
  };
  const auto text_of = [](const Axis& axis, const std::vector<double>& ticks, std::size_t i) {
    if (!axis.names.empty()) return escape_markup(axis.names[i]);
    return axis.log ? log_tick_text(ticks[i]) : tick_text(ticks[i], ticks.size() > 1 ? ticks[1] - ticks[0] : 1.0);
  };
  // Grid lines stand between names, or at numbers.
  const auto grid_at = [](const Axis& axis, double tick) { return axis.names.empty() ? tick : tick - 0.5; };
  const auto x_ticks = ticks_of(x_, f.x, (f.right - f.left) / 90), y_ticks = ticks_of(y_, f.y, (f.bottom - f.top) / 55);
  std::string out;
  for (std::size_t i = 0; i < x_ticks.size(); ++i) {
    out += fmt::format("<path class=\"grid\" d=\"M{0:.1f} {1:.1f}V{2:.1f}\"/>", f.px(grid_at(x_, x_ticks[i])), f.top,
                       f.bottom);
    out += fmt::format("<text class=\"tick\" x=\"{:.1f}\" y=\"{:.1f}\" text-anchor=\"middle\">{}</text>\n",
                       f.px(x_ticks[i]), f.bottom + 17, text_of(x_, x_ticks, i));
  }
  for (std::size_t i = 0; i < y_ticks.size(); ++i) {
    out += fmt::format("<path class=\"grid\" d=\"M{0:.1f} {1:.1f}H{2:.1f}\"/>", f.left, f.py(grid_at(y_, y_ticks[i])),
                       f.right);
    out += fmt::format("<text class=\"tick\" x=\"{:.1f}\" y=\"{:.1f}\" text-anchor=\"end\">{}</text>\n", f.left - 7,
                       f.py(y_ticks[i]) + 4, text_of(y_, y_ticks, i));
  }
  const double x_middle = (f.left + f.right) / 2, y_middle = (f.top + f.bottom) / 2;
  out += fmt::format("<text x=\"{:.1f}\" y=\"{:.1f}\" text-anchor=\"middle\">{}</text>\n", x_middle, f.bottom + 38,
                     escape_markup(x_.label));
  out += fmt::format("<text transform=\"translate(16 {:.1f}) rotate(-90)\" text-anchor=\"middle\">{}</text>\n",
                     y_middle, escape_markup(y_.label));
  out += fmt::format("<text class=\"title\" x=\"{:.1f}\" y=\"24\">{}</text>\n", kLeft, escape_markup(title_));
  return out;
}

std::string Plot::draw(const Series& s, const Frame& f) {
  const std::string colour = svg::paint(s.colour);
  const auto finite = [&](std::size_t i, const std::vector<double>& y) {
    return f.x.drawable(s.x[i]) && f.y.drawable(y[i]);
  };
  const auto dots = [&](double size, double opacity) {
    std::string path;
    for (std::size_t i = 0; i < s.x.size(); ++i) {
      if (finite(i, s.y)) path += fmt::format("M{:.1f} {:.1f}h0", f.px(s.x[i]), f.py(s.y[i]));
    }
    return fmt::format("<path stroke=\"{}\" stroke-width=\"{}\" stroke-linecap=\"round\" opacity=\"{}\" d=\"{}\"/>\n",
                       colour, size, opacity, path);
  };
  std::string path;
  switch (s.kind) {
    case Kind::kLine: {
      bool pen_down = false;
      for (const std::size_t i : thin(std::span(&s.y, 1), kCurvePoints)) {
        const bool drawn = finite(i, s.y);
        if (drawn) path += fmt::format("{}{:.1f} {:.1f}", pen_down ? 'L' : 'M', f.px(s.x[i]), f.py(s.y[i]));
        pen_down = drawn;
      }
      return fmt::format("<path class=\"line\" stroke=\"{}\"{} d=\"{}\"/>\n", colour, dashes(s.stroke), path);
    }
    case Kind::kPoints:
      return dots(4, .6);
    case Kind::kBarsAlongX:
    case Kind::kBarsAlongY: {
      const bool along_x = s.kind == Kind::kBarsAlongX;
      const Range& range = along_x ? f.x : f.y;
      for (std::size_t i = 0; i < s.x.size(); ++i) {
        if (!finite(i, s.y) || !range.drawable(s.low[i]) || !range.drawable(s.high[i])) continue;
        path += along_x ? whisker(f.py(s.y[i]), f.px(s.low[i]), f.px(s.high[i]), true)
                        : whisker(f.px(s.x[i]), f.py(s.low[i]), f.py(s.high[i]), false);
      }
      return fmt::format("<path class=\"line\" stroke=\"{}\" d=\"{}\"/>", colour, path) + dots(7, 1);
    }
    case Kind::kBand: {
      const auto drawn = [&](std::size_t i) { return finite(i, s.low) && finite(i, s.high); };
      for (std::size_t i = 0; i < s.x.size(); ++i) {
        if (drawn(i)) path += fmt::format("{}{:.1f} {:.1f}", path.empty() ? 'M' : 'L', f.px(s.x[i]), f.py(s.high[i]));
      }
      for (std::size_t i = s.x.size(); i-- > 0;) {
        if (drawn(i)) path += fmt::format("L{:.1f} {:.1f}", f.px(s.x[i]), f.py(s.low[i]));
      }
      return fmt::format("<path fill=\"{}\" opacity=\".2\" d=\"{}\"/>\n", colour, path);
    }
    case Kind::kShade:
      return fmt::format("<path fill=\"{}\" opacity=\".12\" d=\"M{:.1f} {:.1f}H{:.1f}V{:.1f}H{:.1f}z\"/>\n", colour,
                         f.px(s.x[0]), f.top, f.px(s.x[1]), f.bottom, f.px(s.x[0]));
  }
  return path;
}

std::string Plot::draw(const Mark& m, bool below, const Frame& f) {
  const double x = f.px(m.x), y = f.py(m.y);
  const bool flip = x + 12 + width_of(m.name) > f.right;
  return fmt::format(
      "<circle cx=\"{:.1f}\" cy=\"{:.1f}\" r=\"5.5\" fill=\"{}\" stroke=\"var(--ink)\"/>"
      "<text class=\"name\" x=\"{:.1f}\" y=\"{:.1f}\" text-anchor=\"{}\">{}</text>\n",
      x, y, svg::paint(m.colour), flip ? x - 10 : x + 10, below ? y + 18 : y - 8, flip ? "end" : "start",
      escape_markup(m.name));
}

// Places in the legend of the named series: x, and y below the first row [px].
std::vector<std::array<double, 2>> Plot::legend_places() const {
  std::vector<std::array<double, 2>> places;
  double x = kLeft, y = 0;
  for (const Series& s : series_) {
    if (s.label.empty()) continue;
    const double width = 28 + width_of(s.label);
    if (x > kLeft && x + width > width_) x = kLeft, y += kLegendRow;
    places.push_back({x, y});
    x += width + 20;
  }
  return places;
}

std::string Plot::legend() const {
  std::string out;
  const auto places = legend_places();
  auto place = places.begin();
  for (const Series& s : series_) {
    if (s.label.empty()) continue;
    const double x = (*place)[0], y = height_ - 12 - places.back()[1] + (*place)[1];
    ++place;
    const std::string colour = svg::paint(s.colour);
    const bool area = s.kind == Kind::kBand || s.kind == Kind::kShade;
    if (s.kind == Kind::kPoints || s.kind == Kind::kBarsAlongX || s.kind == Kind::kBarsAlongY) {
      out += fmt::format("<circle cx=\"{:.1f}\" cy=\"{:.1f}\" r=\"3.5\" fill=\"{}\"/>", x + 11, y - 4, colour);
    } else {
      out += fmt::format("<path stroke=\"{}\" stroke-width=\"{}\" d=\"M{:.1f} {:.1f}h22\"{}{}/>", colour,
                         area ? 10 : 2.5, x, y - 4, area ? " opacity=\".3\"" : "", dashes(s.stroke));
    }
    out += fmt::format("<text x=\"{:.1f}\" y=\"{:.1f}\">{}</text>\n", x + 28, y, escape_markup(s.label));
  }
  return out;
}

std::string Plot::render() const {
  const Frame f = frame();
  std::string out = svg::open(width_, height_, description_.empty() ? title_ : description_);
  out += axes(f);
  if (x_limit_ || y_limit_) {  // an inner <svg> cuts off what lies beyond it
    out += fmt::format(R"(<svg x="{0}" y="{1}" width="{2}" height="{3}" viewBox="{0} {1} {2} {3}">)", f.left, f.top,
                       f.right - f.left, f.bottom - f.top);
  }
  for (const Series& s : series_) out += draw(s, f);
  if (x_limit_ || y_limit_) out += "</svg>\n";
  bool below = false;  // names of coinciding marks stand above and below
  for (const Mark& m : marks_) {
    out += draw(m, below, f);
    below = !below;
  }
  return out + legend() + "</svg>\n";
}

Figure as_figure(std::string name, Plot plot, std::string caption) {
  std::string svg = plot.render();
  return {std::move(name), std::move(svg), std::move(caption), std::make_shared<const Plot>(std::move(plot))};
}

}  // namespace piste
