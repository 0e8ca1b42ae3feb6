#include "report/page_data.h"

#include <fmt/format.h>

#include <span>

#include "io/json.h"
#include "math/gps_time.h"
#include "piste/math/units.h"
#include "plot/markup.h"
#include "report/assets.h"

namespace piste::page {
namespace {

constexpr int kTimeDigits = 16;

std::string intervals(std::span<const Interval> of) {
  std::vector<std::string> out;
  for (const Interval& i : of) {
    out.push_back(json::array({json::number(i.start, kTimeDigits), json::number(i.end, kTimeDigits)}));
  }
  return json::array(out);
}

std::string curve(const Curve& c) {
  json::Members members{{"label", json::string(c.label)}, {"value", json::string(c.value)}};
  for (const auto& [name, column] : {std::pair{"sigma", c.sigma}, {"low", c.low}, {"high", c.high}}) {
    if (!column.empty()) members.emplace_back(name, json::string(column));
  }
  if (!c.table.empty()) members.emplace_back("table", json::string(c.table));
  if (!c.stroke.empty()) members.emplace_back("stroke", json::string(c.stroke));
  if (c.colour) members.emplace_back("colour", fmt::format("{}", *c.colour));
  return json::object(members);
}

std::string chart(const Chart& c) {
  std::vector<std::string> curves;
  for (const Curve& of : c.curves) curves.push_back(curve(of));
  json::Members members{
      {"name", json::string(c.name)},   {"title", json::string(c.title)},    {"unit", json::string(c.unit)},
      {"table", json::string(c.table)}, {"points", json::boolean(c.points)}, {"log", json::boolean(c.log)},
      {"turn", json::number(c.turn)},   {"levels", json::numbers(c.levels)}, {"curves", json::array(curves)}};
  if (!c.axis.empty()) members.emplace_back("axis", json::string(c.axis));
  if (c.limits) members.emplace_back("limits", json::numbers(*c.limits));
  return json::object(members);
}

std::string axis(const Axis& a) {
  std::vector<std::string> shades;
  for (const Shade& s : a.shades) {
    shades.push_back(json::object({{"from", json::number(s.from, kTimeDigits)},
                                   {"to", json::number(s.to, kTimeDigits)},
                                   {"kind", json::string(s.kind)}}));
  }
  return json::object({{"label", json::string(a.label)},
                       {"unit", json::string(a.unit)},
                       {"log", json::boolean(a.log)},
                       {"start", json::number(a.start, kTimeDigits)},
                       {"end", json::number(a.end, kTimeDigits)},
                       {"shades", json::array(shades)}});
}

std::string places(const Places& p) {
  std::vector<std::string> lines;
  for (const PlacedLine& line : p.lines) {
    lines.push_back(json::object({{"table", json::string(line.table)}, {"colour", fmt::format("{}", line.colour)}}));
  }
  return json::object({{"name", json::string(p.name)}, {"axis", json::string(p.axis)}, {"lines", json::array(lines)}});
}

// UTC of time 0 [s since 1970], by the leap seconds at the start; `null` without a week.
std::string utc_of_zero(const Data& data) {
  if (!data.week) return "null";
  return json::number(unix_time({*data.week, data.start}) - data.start, kTimeDigits);
}

std::string text(const Data& data) {
  json::Members tables, axes;
  std::vector<std::string> charts, pictures;
  for (const Places& p : data.places) pictures.push_back(places(p));
  for (const Axis& a : data.axes) axes.emplace_back(a.name, axis(a));
  for (const auto& [name, table] : data.tables) tables.emplace_back(name, table);
  for (const Chart& c : data.charts) charts.push_back(chart(c));
  std::string origin = "null";
  if (data.origin) {
    origin = json::array({json::number(kDegreesPerRadian * data.origin->latitude, kTimeDigits),
                          json::number(kDegreesPerRadian * data.origin->longitude, kTimeDigits),
                          json::number(data.origin->height, kTimeDigits)});
  }
  return json::object({{"start", json::number(data.start, kTimeDigits)},
                       {"end", json::number(data.end, kTimeDigits)},
                       {"utc", utc_of_zero(data)},
                       {"origin", origin},
                       {"rest", intervals(data.rest)},
                       {"outages", intervals(data.outages)},
                       {"sources", json::strings(data.sources)},
                       {"axes", json::object(axes)},
                       {"charts", json::array(charts)},
                       {"places", json::array(pictures)},
                       {"tables", json::object(tables)}},
                      1);
}

constexpr std::string_view kNotice =
    "<p id=\"notice\" class=\"bad\" hidden></p>\n<noscript><p class=\"bad\">Plan and charts need JavaScript; the "
    "tables do "
    "not.</p></noscript>\n";

constexpr std::string_view
    kTools = R"(<div class="tools" id="tools" hidden>
)",
    kTimeTools =
        R"(<fieldset id="which" aria-label="Solution shown"><label><input type="radio" name="solution" value="smoothed" checked autocomplete="off"> smoothed</label>
<label><input type="radio" name="solution" value="filtered" autocomplete="off"> filtered</label></fieldset>
<label>time in <select id="clock"><option value="seconds">s since the start</option><option value="week">s of week</option></select></label>
<button type="button" id="reset">whole run</button>
<output id="window"></output>
</div>
)",
    kPlainTools = R"(<button type="button" id="reset">whole curves</button>
</div>
)";

constexpr std::string_view kPlan =
    R"(<div class="plan"><div class="plan-tools"><label>colour <select id="colour"><option value="speed">speed</option><option value="sigma">horizontal sigma</option><option value="height">height</option><option value="time">time</option><option value="quality">fixes used</option></select></label>
<label><input type="checkbox" id="fixes-shown" checked autocomplete="off"> fixes</label>
<label><input type="checkbox" id="ellipses-shown" autocomplete="off"> sigmas</label>
<details><summary>map</summary><p class="soft">Nothing is fetched unless you name a source of tiles, such as <code>https://…/{z}/{x}/{y}.png</code> or a folder.</p><input id="tiles" size="24" aria-label="Address of tiles"> <button type="button" id="tiles-on">show</button></details></div>
<div id="plan" role="img" aria-label="Plan of the track, north up"></div><div id="scale" class="soft"></div></div>
)";

}  // namespace

Curve envelope_curve(std::string label, const std::string& signal, bool extremes) {
  Curve out{.label = std::move(label), .value = signal};
  if (extremes) out.low = signal + "_least", out.high = signal + "_most";
  return out;
}

std::string tools(bool over_time) {
  return fmt::format("{}{}{}", kNotice, kTools, over_time ? kTimeTools : kPlainTools);
}

std::string plan(bool quality) {
  std::string out(kPlan);
  constexpr std::string_view kQuality = "<option value=\"quality\">fixes used</option>";
  if (const auto at = out.find(kQuality); !quality && at != std::string::npos) out.erase(at, kQuality.size());
  return out;
}

std::string no_charts() {
  return "<p>No plan and no chart is here, as piste was built without dygraphs and Leaflet (Debian: "
         "<code>libjs-dygraphs</code>, <code>libjs-leaflet</code>). The CSV files hold what they would show.</p>\n";
}

bool draws() { return !assets::dygraphs_js().empty() && !assets::leaflet_js().empty(); }

std::string scripts(const Data& data) {
  if (!draws()) return {};
  return fmt::format(
      "<script type=\"application/json\" "
      "id=\"page-data\">{}</script>\n<script>\n{}\n</script>\n<script>\n{}\n</script>\n"
      "<script>\n'use strict';\n(function () {{\n{}}})();\n</script>\n",
      text(data), assets::dygraphs_js(), data.origin ? assets::leaflet_js() : "", assets::page_js());
}

std::string place(std::string_view chart) {
  return fmt::format("<div class=\"place\" data-chart=\"{}\"></div>\n", chart);
}

std::string groups(const Data& data) {
  std::string out;
  for (const Group& group : data.groups) {
    std::string places;
    for (const Chart& c : data.charts) {
      if (c.group == group.name) places += place(c.name);
    }
    if (places.empty()) continue;
    out += fmt::format("<details class=\"group\" id=\"{}\"{}>\n<summary><h3>{}</h3></summary>\n", group.name,
                       group.open ? " open" : "", escape_markup(group.title));
    if (!group.note.empty()) out += fmt::format("<p class=\"soft\">{}</p>\n", escape_markup(group.note));
    out += fmt::format("<div class=\"charts\">\n{}</div>\n</details>\n", places);
  }
  return out;
}

}  // namespace piste::page
