#include "piste/report/html.h"

#include <fmt/format.h>

#include <array>
#include <cmath>
#include <span>
#include <utility>

#include "math/words.h"
#include "plot/markup.h"
#include "plot/svg.h"
#include "plot/thin.h"
#include "report/assets.h"
#include "report/charts.h"
#include "report/page.h"

namespace piste {
namespace {

constexpr std::size_t kChartRows = 2000;  // keeps a page with every block and both solutions below 5 MB
constexpr std::size_t kPlanPoints = 3000;

using page::Row;
using page::table;

std::string number(std::size_t n) { return fmt::format("{}", n); }

double start_of(const Solution& solution) { return solution.empty() ? 0 : solution.time(0); }

/// One row for each source, or none without sources.
void per_source(std::vector<Row>& rows, std::string_view name, std::string_view fate,
                const std::vector<std::size_t>& counts) {
  for (std::size_t i = 0; i < counts.size(); ++i) {
    rows.push_back({fmt::format("{}[{}] fixes {}", name, i, fate), number(counts[i])});
  }
}

/// The rows that `repair` changed, if any.
void repaired_rows(std::vector<Row>& rows, const std::string& name, const RepairedRows& repaired) {
  if (repaired.sorted > 0) rows.push_back({name + " rows put in the order of time", number(repaired.sorted)});
  if (repaired.unreadable > 0) rows.push_back({name + " rows left out as unreadable", number(repaired.unreadable)});
  if (repaired.dropped > 0) rows.push_back({name + " rows of a repeated time dropped", number(repaired.dropped)});
}

std::string log_table(const ReplayReport& report) {
  const Log& log = *report.log;
  std::vector<Row> rows{{"IMU epochs", number(log.imu.size())},
                        {"IMU gaps", number(log.counts.imu_gaps)},
                        {"IMU samples rejected", number(log.counts.imu_rejected)},
                        {"IMU samples clipped", number(log.counts.imu_clipped)},
                        {"IMU spikes interpolated", number(log.counts.imu_spikes)}};
  if (log.counts.imu_unpaired > 0) {
    rows.push_back({"IMU rows without those of the other file", number(log.counts.imu_unpaired)});
  }
  repaired_rows(rows, "IMU", log.counts.imu_repaired);
  for (std::size_t i = 0; i < log.counts.gnss_repaired.size(); ++i) {
    repaired_rows(rows, fmt::format("gnss[{}]", i), log.counts.gnss_repaired[i]);
  }
  for (std::size_t i = 0; i < log.counts.attitude_repaired.size(); ++i) {
    repaired_rows(rows, fmt::format("attitude[{}]", i), log.counts.attitude_repaired[i]);
  }
  per_source(rows, "gnss", "withheld", log.counts.gnss_withheld);
  per_source(rows, "gnss", "outside the IMU's span", log.counts.gnss_outside);
  per_source(rows, "attitude", "outside the IMU's span", log.counts.attitude_outside);
  rows.push_back({"GNSS fixes too late", number(report.filtered->gnss_late)});
  rows.push_back({"Rest intervals", number(log.rest.size())});
  return table("What came in", {}, rows);
}

std::string source_table(const Solution& solution) {
  std::vector<std::array<std::size_t, kOutcomes.size()>> counts(solution.sources.size());
  for (const Innovation& z : solution.innovations) {
    ++counts.at(static_cast<std::size_t>(z.source)).at(static_cast<std::size_t>(z.outcome));
  }
  std::vector<Row> rows;
  for (std::size_t i = 0; i < counts.size(); ++i) {
    Row& row = rows.emplace_back(Row{solution.sources[i]});
    for (const std::size_t count : counts[i]) row.push_back(number(count));
  }
  Row head{"source"};
  for (const Outcome outcome : kOutcomes) head.emplace_back(outcome_name(outcome));
  return table("Measurements", head, rows);
}

std::string verdict_section(const Verdict& verdict) {
  std::vector<Row> rows;
  const auto shown = [](double value) { return std::isnan(value) ? "too few" : fmt::format("{:.2f}", value); };
  for (const SourceVerdict& s : verdict.sources) {
    rows.push_back({s.name, shown(s.nis), shown(s.whiteness), fmt::format("{:.1f} %", 100 * s.rejected),
                    std::isnan(s.smoothed) ? "" : shown(s.smoothed), s.holds ? "yes" : "no"});
  }
  std::string out = page::list("Causes, the likeliest first:", verdict.findings);
  if (!rows.empty()) {
    out += table(
        "Do the sigmas hold? Under way",
        {"source", "NIS (1)", "correlation (0)", "rejected (0.1 %)", "smoothed residual in sigmas (1)", "holds"}, rows);
  }
  std::vector<Row> jumps;
  constexpr std::size_t kShown = 5;
  for (const PriorJump& jump : verdict.jumps) {
    if (jumps.size() < kShown) jumps.push_back({jump.name, fmt::format("{:+.1f}", jump.sigmas)});
  }
  if (!jumps.empty()) out += table("Furthest from their priors", {"constant", "sigmas"}, jumps);
  return "<div class=\"tables\">\n" + out + "</div>\n";
}

std::string rest_table(const Log& log, double start) {
  if (log.rest.empty()) return {};
  std::vector<Row> rows;
  for (const Interval& r : log.rest) {
    rows.push_back(
        {fmt::format("{:.2f} to {:.2f}", r.start - start, r.end - start), fmt::format("{:.2f}", r.end - r.start)});
  }
  return table("Rest", {"interval [s]", "length [s]"}, rows);
}

std::string estimate_table(const Solution& solution) {
  if (solution.empty()) return {};
  const std::size_t last = solution.size() - 1;
  const Estimate x = solution.estimate(last);
  const Sigmas s = solution.sigmas(last);
  std::vector<Row> rows;
  for (const Block block : solution.layout().blocks()) {
    if (is_navigation(block)) continue;
    const BlockInfo& row = info(block);
    const BlockValues value = shown_value(x, block);
    for (int first = 0; first < row.size; first += 3) {
      Row cells{first == 0 ? fmt::format("{} [{}]", row.name, row.unit) : ""};
      for (int i = first; i < first + 3; ++i) {
        cells.push_back(
            i < row.size ? fmt::format("{}: {}", row.axes[static_cast<std::size_t>(i)],
                                       measured(value[i] * row.factor, s.blocks[full_offset(block) + i] * row.factor))
                         : "");
      }
      rows.push_back(std::move(cells));
    }
  }
  if (rows.empty()) return {};
  return table("Estimates at the end, ± 1 sigma (boresight: roll, pitch, heading)", {"block", "", "", ""}, rows);
}

/// East and north, thinned.
using Plan = std::array<std::vector<double>, 2>;

Plan thinned(const Plan& all) {
  Plan out;
  for (const std::size_t i : thin(all, kPlanPoints)) {
    for (std::size_t k = 0; k < 2; ++k) out[k].push_back(all[k][i]);
  }
  return out;
}

Plan plan_of(const Solution& solution) {
  Plan plan;
  for (std::size_t i = 0; i < solution.size(); ++i) {
    const Vector3d p = solution.position(i);
    plan[0].push_back(p.y());
    plan[1].push_back(p.x());
  }
  return thinned(plan);
}

std::string plan_view(const ReplayReport& report) {
  Plot plot("Plan view", {"east [m]"}, {"north [m]"},
            "Plan view of the track, east against north in metres, with start and end");
  plot.equal_scale();
  plot.size(980, 640);
  for (std::size_t i = 0; i < report.log->gnss.size(); ++i) {
    Plan fixes;
    for (const GnssFix& fix : report.log->gnss[i]) {
      fixes[0].push_back(fix.position.y());
      fixes[1].push_back(fix.position.x());
    }
    fixes = thinned(fixes);
    plot.points(std::move(fixes[0]), std::move(fixes[1]), 6, fmt::format("gnss[{}], antenna", i));
  }
  Plan track = plan_of(*report.filtered);
  const bool both = report.smoothed != nullptr;
  plot.line(track[0], track[1], both ? 1 : 0, "filtered");
  if (both) {
    track = plan_of(*report.smoothed);
    plot.line(track[0], track[1], 0, "smoothed");
  }
  if (!track[0].empty()) {
    plot.mark(track[0].front(), track[1].front(), 2, "start");
    plot.mark(track[0].back(), track[1].back(), 3, "end");
  }
  return plot.render();
}

std::string json_intervals(std::span<const Interval> intervals, double start) {
  std::string out = "[";
  for (const Interval& i : intervals)
    out += fmt::format("{}[{:.3f},{:.3f}]", out.size() > 1 ? "," : "", i.start - start, i.end - start);
  return out + ']';
}

std::string json_charts(std::span<const charts::Chart> charts) {
  std::string out = "[";
  for (const auto& chart : charts) {
    if (out.size() > 1) out += ',';
    out += charts::json(chart, kChartRows);
  }
  return out + ']';
}

std::string data_script(const ReplayReport& report, double start) {
  std::string out = "<script>\nconst report = {solutions: {\"filtered\": " +
                    json_charts(charts::of_solution(*report.filtered, start));
  if (report.smoothed) out += ",\n\"smoothed\": " + json_charts(charts::of_solution(*report.smoothed, start));
  out += "},\ninnovations: " + json_charts(charts::of_innovations(*report.filtered, start));
  out += ",\nrest: " + json_intervals(report.log->rest, start);
  out += ",\noutages: " + json_intervals(report.outages, start);
  return out + "};\n</script>\n";
}

constexpr std::string_view kSwitch = R"(<fieldset class="switch" aria-label="Solution shown">
<label><input type="radio" name="solution" value="smoothed" checked autocomplete="off"> smoothed</label>
<label><input type="radio" name="solution" value="filtered" autocomplete="off"> filtered</label>
</fieldset>
)";

constexpr std::string_view kNoCharts =
    "<p>No chart is here, as piste was built without dygraphs (Debian: <code>libjs-dygraphs</code>). The CSV files "
    "hold what "
    "it would show.</p>\n";

}  // namespace

std::string html_report(const ReplayReport& report) {
  const double start = start_of(*report.filtered);
  const Solution& best = report.smoothed ? *report.smoothed : *report.filtered;
  const double length = best.empty() ? 0 : best.time(best.size() - 1) - start;
  std::string subtitle = fmt::format("piste {} · {:.1f} s from time_s {:.3f}; times below count from there",
                                     escape_markup(report.version), length, start);
  if (report.verdict != nullptr)
    subtitle += fmt::format("<br><strong>{}</strong>", escape_markup(verdict_line(*report.verdict)));
  const bool charts = !assets::dygraphs_js().empty();
  std::string over_time = "<p class=\"soft\">Bands are ± 1 sigma. Rest is shaded";
  if (!report.outages.empty()) over_time += ", withheld GNSS is shaded red";
  over_time +=
      ". Drag to zoom every chart, double-click to see all again. "
      "Long series are thinned: lines keep the extremes among 40 000 epochs of the run, dots are a fair sample.</p>\n"
      "<noscript><p>The charts need JavaScript; the tables and the plan view do not.</p></noscript>\n";
  if (report.smoothed) over_time += kSwitch;
  over_time += "<section id=\"solution-charts\"></section>\n";
  const std::string innovations =
      "<p class=\"soft\">Measured minus predicted, of the filter. NIS is the squared residual in units of its "
      "covariance; beyond the gate a measurement is rejected.</p>\n<section id=\"innovation-charts\"></section>\n";
  const std::string scripts = charts
                                  ? fmt::format("<script>\n{}\n</script>\n{}<script>\n{}</script>\n",
                                                assets::dygraphs_js(), data_script(report, start), assets::report_js())
                                  : "";
  return page::render(report.title, subtitle,
                      {{"summary", "Summary",
                        (report.verdict != nullptr ? verdict_section(*report.verdict) : "") +
                            "<div class=\"tables\">\n" + log_table(report) + source_table(*report.filtered) +
                            rest_table(*report.log, start) + "</div>\n" + estimate_table(best)},
                       {"plan", "Plan view", "<figure>\n" + plan_view(report) + "</figure>\n"},
                       {"over-time", "Over time", charts ? over_time : std::string(kNoCharts)},
                       {"innovations", "Innovations", charts ? innovations : std::string(kNoCharts)},
                       {"config", "Configuration", fmt::format("<pre>{}</pre>\n", escape_markup(report.config_text))}},
                      assets::dygraphs_css(), scripts);
}

}  // namespace piste
