#include "plot/heat_map.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "plot/markup.h"
#include "plot/svg_frame.h"

namespace piste {
namespace {

constexpr double kCellWidth = 84, kCellHeight = 34, kHeader = 66, kMargin = 18, kLetterWidth = 7.5;  // [px]
constexpr double kFaintest = 0.04, kStrongest = 0.6;  // opacity: a number stays legible on its cell
constexpr double kKeyCell = 34, kKeyHeight = 14;
constexpr int kKeySteps = 4;  // on either side

std::string cell(double x, double y, double width, double height, double value) {
  const double opacity = kFaintest + (kStrongest - kFaintest) * std::min(1.0, std::abs(value));
  return fmt::format(
      "<path fill=\"var(--c{})\" opacity=\"{:.3f}\" stroke=\"var(--grid)\" d=\"M{:.1f} {:.1f}h{}v{}h-{}z\"/>\n",
      value < 0 ? 1 : 0, opacity, x, y, width, height, width);
}

std::string text(double x, double y, std::string_view anchor, std::string_view style, std::string_view what) {
  return fmt::format("<text{} x=\"{:.1f}\" y=\"{:.1f}\" text-anchor=\"{}\">{}</text>\n", style, x, y, anchor,
                     escape_markup(what));
}

constexpr std::string_view kSoft = " class=\"tick\"";

// The key of the colours, from −1 to 1.
std::string key(double x, double y) {
  std::string out;
  for (int step = -kKeySteps; step <= kKeySteps; ++step) {
    const double value = static_cast<double>(step) / kKeySteps;
    const double left = x + kKeyCell * (step + kKeySteps);
    out += cell(left, y, kKeyCell, kKeyHeight, value);
    if (step % 2 != 0) continue;
    out += text(left + kKeyCell / 2, y + kKeyHeight + 14, "middle", kSoft, decimal(value, 1));
  }
  return out;
}

}  // namespace

std::string HeatMap::render() const {
  double left = kMargin;
  for (const std::string& name : rows) {
    left = std::max(left, 2 * kMargin + kLetterWidth * static_cast<double>(svg::letters(name)));
  }
  const double bottom = kHeader + kCellHeight * static_cast<double>(rows.size());
  const double inside = std::max(kCellWidth * static_cast<double>(columns.size()), (2 * kKeySteps + 1) * kKeyCell);
  std::string out = svg::open(static_cast<int>(std::ceil(left + inside + kMargin)), static_cast<int>(bottom) + 62,
                              description.empty() ? title : description);
  out += text(kMargin, 24, "start", " class=\"title\"", title);
  for (std::size_t c = 0; c < columns.size(); ++c) {
    out += text(left + kCellWidth * (static_cast<double>(c) + 0.5), kHeader - 8, "middle", "", columns[c]);
  }
  for (std::size_t r = 0; r < rows.size(); ++r) {
    const double y = kHeader + kCellHeight * static_cast<double>(r), middle = y + kCellHeight / 2 + 4;
    out += text(left - 10, middle, "end", "", rows[r]);
    for (std::size_t c = 0; c < columns.size(); ++c) {
      const double value = values[r][c], x = left + kCellWidth * static_cast<double>(c);
      if (!std::isfinite(value)) continue;
      out += cell(x, y, kCellWidth, kCellHeight, value);
      out += text(x + kCellWidth / 2, middle, "middle", "", decimal(value, 2));
    }
  }
  return out + key(left, bottom + 16) + "</svg>\n";
}

}  // namespace piste
