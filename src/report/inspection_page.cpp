#include "piste/report/inspection_page.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <string_view>
#include <utility>
#include <vector>

#include "piste/math/earth.h"
#include "piste/math/statistics.h"
#include "piste/math/units.h"
#include "piste/report/inspection_text.h"
#include "plot/markup.h"
#include "report/packed_table.h"
#include "report/page.h"
#include "report/page_data.h"

namespace piste {
namespace {

constexpr std::array kBody{"x", "y", "z"};
constexpr std::array kLocal{"north", "east", "down"};

/// What the page draws of all logs. Logs on different clocks each count from their own first row.
struct Drawn {
  page::Data data;
  bool one_clock = true;
  double first(double of_log) const { return one_clock ? 0 : of_log; }
};

std::optional<Interval> span_of(const InspectedLog& log) {
  if (log.imu_health && !log.imu.time.empty()) return Interval{log.imu.time.front(), log.imu.time.back()};
  if (log.gnss_health && !log.gnss.fixes.empty())
    return Interval{log.gnss.fixes.front().time, log.gnss.fixes.back().time};
  return std::nullopt;
}

void add_spans(Drawn& drawn, double first, const std::vector<Interval>& rest, const std::vector<Interval>& gaps) {
  for (const Interval& i : rest) drawn.data.rest.push_back({i.start - first, i.end - first});
  for (const Interval& i : gaps) drawn.data.outages.push_back({i.start - first, i.end - first});
}

void add_chart(Drawn& drawn, std::size_t number, std::string_view what, std::string title, std::string unit,
               std::vector<page::Curve> curves) {
  drawn.data.charts.push_back({.name = fmt::format("log_{}_{}", number, what),
                               .title = std::move(title),
                               .unit = std::move(unit),
                               .group = fmt::format("log_{}", number),
                               .table = fmt::format("log_{}", number),
                               .curves = std::move(curves)});
}

void add_imu(Drawn& drawn, const InspectedLog& log, std::size_t number) {
  const ImuRecording& imu = log.imu;
  const double first = drawn.first(imu.time.front());
  page::Envelope envelope({"rate_x", "rate_y", "rate_z", "force_x", "force_y", "force_z"}, imu.time.size());
  for (std::size_t i = 0; i < imu.time.size(); ++i) {
    const double per = !imu.increments ? 1 : i > 0 ? imu.time[i] - imu.time[i - 1] : log.imu_health->sampling.interval;
    Eigen::Matrix<double, 6, 1> row;
    row << kDegreesPerRadian / per * imu.gyro[i], imu.accel[i] / per;
    envelope.add(imu.time[i] - first, {row.data(), 6});
  }
  drawn.data.tables.emplace_back(fmt::format("log_{}", number), envelope.json());
  std::vector<page::Curve> rate, force;
  for (const char* axis : kBody) {
    rate.push_back(page::envelope_curve(axis, fmt::format("rate_{}", axis), envelope.has_extremes()));
    force.push_back(page::envelope_curve(axis, fmt::format("force_{}", axis), envelope.has_extremes()));
  }
  add_chart(drawn, number, "rate", "Angular rate, sensor axes, as labelled", "deg/s", std::move(rate));
  add_chart(drawn, number, "force", "Specific force, sensor axes, as labelled", "m/s²", std::move(force));
  add_spans(drawn, first, log.imu_health->rest, log.imu_health->sampling.gaps);
}

std::string fixes_table(const std::vector<GeodeticFix>& fixes, const World& world, double first) {
  std::vector<double> time, height;
  std::array<std::vector<double>, 3> place, sigma, velocity;
  for (const GeodeticFix& fix : fixes) {
    time.push_back(fix.time - first);
    height.push_back(fix.position.height);
    const Vector3d p = world.from_geodetic(fix.position);
    for (std::size_t k = 0; k < 3; ++k) {
      const auto axis = static_cast<Eigen::Index>(k);
      place[k].push_back(p[axis]);
      sigma[k].push_back(fix.sigma_position[axis]);
      velocity[k].push_back(fix.velocity ? fix.velocity->value[axis] : kNaN);
    }
  }
  constexpr double kStep = 1e-5, kTimeStep = 1e-6;
  page::PackedTable table;
  table.add("time_s", time, kTimeStep);
  table.add("height_m", height, page::step_below(sigma[2], kStep));
  for (std::size_t k = 0; k < 3; ++k) {
    if (k < 2) table.add(fmt::format("{}_m", kLocal[k]), place[k], page::step_below(sigma[k], kStep));
    table.add_sigma(fmt::format("sigma_{}_m", kLocal[k]), sigma[k]);
    table.add(fmt::format("velocity_{}_m_s", kLocal[k]), velocity[k], 1e-3);
  }
  return table.json();
}

void add_gnss(Drawn& drawn, const InspectedLog& log, std::size_t number) {
  const std::vector<GeodeticFix>& fixes = log.gnss.fixes;
  const double first = drawn.first(fixes.front().time);
  const World world(fixes.front().position);
  const std::string table = fixes_table(fixes, world, first);
  drawn.data.tables.emplace_back(fmt::format("log_{}", number), table);
  if (!drawn.data.origin) {  // the plan is that of the first receiver
    drawn.data.origin = world.origin();
    drawn.data.tables.emplace_back("track", table);
  }
  add_chart(drawn, number, "height", "Height above the ellipsoid", "m",
            {{.label = "height", .value = "height_m", .sigma = "sigma_down_m"}});
  std::vector<page::Curve> velocity, sigma;
  for (const char* axis : kLocal) {
    velocity.push_back({.label = axis, .value = fmt::format("velocity_{}_m_s", axis)});
    sigma.push_back({.label = axis, .value = fmt::format("sigma_{}_m", axis)});
  }
  if (std::ranges::any_of(fixes, [](const GeodeticFix& fix) { return fix.velocity.has_value(); })) {
    add_chart(drawn, number, "velocity", "Velocity", "m/s", std::move(velocity));
  }
  add_chart(drawn, number, "sigma", "Sigma of the position, as stated", "m", std::move(sigma));
  add_spans(drawn, first, log.gnss_health->rest, log.gnss_health->sampling.gaps);
}

Drawn drawn_of(const Inspection& inspection) {
  Drawn drawn;
  double latest_start = -INFINITY, earliest_end = INFINITY;
  for (const InspectedLog& log : inspection.logs) {
    const auto span = span_of(log);
    if (!span) continue;
    latest_start = std::max(latest_start, span->start);
    earliest_end = std::min(earliest_end, span->end);
  }
  drawn.one_clock = latest_start < earliest_end;
  drawn.data.start = INFINITY;
  drawn.data.end = -INFINITY;
  for (std::size_t i = 0; i < inspection.logs.size(); ++i) {
    const InspectedLog& log = inspection.logs[i];
    const auto span = span_of(log);
    if (!span) continue;
    drawn.data.start = std::min(drawn.data.start, span->start - drawn.first(span->start));
    drawn.data.end = std::max(drawn.data.end, span->end - drawn.first(span->start));
    if (log.imu_health && !log.imu.time.empty()) add_imu(drawn, log, i + 1);
    if (log.gnss_health && !log.gnss.fixes.empty()) add_gnss(drawn, log, i + 1);
  }
  return drawn;
}

std::string charts_of(const page::Data& data, std::size_t number) {
  std::string out;
  for (const page::Chart& chart : data.charts) {
    if (chart.group == fmt::format("log_{}", number)) out += page::place(chart.name);
  }
  return out.empty() ? "" : fmt::format("<div class=\"charts\">\n{}</div>\n", out);
}

std::string suspicions_body(const std::vector<Suspicion>& suspicions) {
  if (suspicions.empty()) return "<p>Nothing looks wrong.</p>\n";
  std::string out;
  const auto items = [&](bool severe, std::string_view heading) {
    std::vector<std::string> list;
    for (const Suspicion& s : suspicions) {
      if (is_severe(s.fault) == severe) list.push_back(fmt::format("{}: {} — {}", s.file, s.what, s.remedy));
    }
    out += page::list(heading, list);
  };
  items(true, "To be corrected, the worst first:");
  items(false, "Worth knowing:");
  return out;
}

std::string sheet_table(const InspectionSheet& sheet) {
  std::string out = fmt::format("<div class=\"wide\">\n<table><caption>{}</caption>\n", escape_markup(sheet.title));
  for (const auto& [name, text] : sheet.facts)
    out += fmt::format("<tr><th scope=\"row\">{}</th><td>{}</td></tr>\n", escape_markup(name), escape_markup(text));
  return out + "</table>\n</div>\n";
}

}  // namespace

std::string inspection_page(const Inspection& inspection, const std::optional<std::string>& config,
                            const std::string& version) {
  const Drawn drawn = drawn_of(inspection);
  const bool charts = page::draws() && !drawn.data.charts.empty();
  std::vector<page::Section> sections{{"wrong", "What looks wrong", suspicions_body(inspection.suspicions)}};
  const std::vector<InspectionSheet> sheets = inspection_sheets(inspection);
  for (std::size_t i = 0; i < sheets.size(); ++i) {
    page::Section section{fmt::format("log_{}", i + 1), "", sheet_table(sheets[i])};
    if (i < inspection.logs.size()) {
      const InspectedLog& log = inspection.logs[i];
      section.heading = fmt::format("Log {}{}", i + 1, log.guess ? fmt::format(": {}", name_of(log.guess->kind)) : "");
      if (charts) section.body += charts_of(drawn.data, i + 1);
    } else {
      section.heading = fmt::format("Match {}", i + 1 - inspection.logs.size());
    }
    sections.push_back(std::move(section));
  }
  if (config) {
    sections.push_back(
        {"configuration", "A configuration for replay", fmt::format("<pre>{}</pre>\n", escape_markup(*config))});
  }
  std::string head = charts ? page::tools() : page::no_charts();
  if (charts && !drawn.one_clock) {
    head += "<p class=\"soft\">The logs are not on one clock: each counts from its own first row.</p>\n";
  }
  if (charts && drawn.data.origin) sections.insert(sections.begin() + 1, {"track", "Track", page::plan(false)});
  return page::render({.title = "Inspection",
                       .subtitle = fmt::format("piste {} · {} logs", escape_markup(version), inspection.logs.size()),
                       .head = head,
                       .sections = sections,
                       .style = page::styles(),
                       .scripts = charts ? page::scripts(drawn.data) : ""});
}

}  // namespace piste
