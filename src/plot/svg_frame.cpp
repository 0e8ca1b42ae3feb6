#include "plot/svg_frame.h"

#include <fmt/format.h>

#include <algorithm>

#include "plot/markup.h"

namespace piste::svg {
namespace {

// Colours are those of Okabe and Ito, made darker or lighter so that they are legible on both grounds.
constexpr std::string_view kStyle =
    R"(.plot{--ink:#24292f;--soft:#57606a;--grid:#d0d7de;--c0:#0067b8;--c1:#c04f00;--c2:#00805c;--c3:#a8417f;--c4:#8a6d00;--c5:#2a8fc4;--c6:#767f88}
@media(prefers-color-scheme:dark){.plot{--ink:#e6edf3;--soft:#9da7b1;--grid:#3a424b;--c0:#5aaeff;--c1:#ff9350;--c2:#3fc79a;--c3:#e58cc4;--c4:#e0c04a;--c5:#7fd0ff;--c6:#98a2ad}}
@media print{.plot{--ink:#000;--soft:#444;--grid:#ccc;--c0:#0067b8;--c1:#c04f00;--c2:#00805c;--c3:#a8417f;--c4:#8a6d00;--c5:#2a8fc4;--c6:#767f88}}
.plot{font:13px system-ui,sans-serif;max-width:100%;height:auto}
.plot text{fill:var(--ink)}.plot .tick{fill:var(--soft);font-size:12px}.plot .title{font-weight:600;font-size:15px}
.plot .grid{stroke:var(--grid);stroke-width:1}.plot .line{fill:none;stroke-width:1.6;stroke-linejoin:round}
.plot .name{paint-order:stroke;font-weight:600})";

}  // namespace

std::string open(int width, int height, std::string_view description) {
  return fmt::format(
      "<svg xmlns=\"http://www.w3.org/2000/svg\" class=\"plot\" viewBox=\"0 0 {0} {1}\" width=\"{0}\" height=\"{1}\" "
      "role=\"img\" aria-label=\"{2}\">\n<style>{3}</style>\n",
      width, height, escape_markup(description), kStyle);
}

std::string paint(int colour) {
  if (colour == kInk) return "var(--ink)";
  return fmt::format("var(--c{})", ((colour % 7) + 7) % 7);
}

std::size_t letters(std::string_view text) {
  return static_cast<std::size_t>(std::count_if(text.begin(), text.end(), [](char c) { return (c & 0xC0) != 0x80; }));
}

}  // namespace piste::svg
