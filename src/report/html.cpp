#include "piste/report/html.h"

#include <fmt/format.h>

#include <array>
#include <cctype>
#include <cmath>
#include <string_view>
#include <utility>

#include "math/gps_time.h"
#include "math/words.h"
#include "piste/math/statistics.h"
#include "piste/math/units.h"
#include "piste/replay/replay.h"
#include "plot/markup.h"
#include "report/page.h"
#include "report/page_data.h"
#include "report/replay_charts.h"

namespace piste {
namespace {

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
  std::vector<std::string> reasons;
  for (const SourceVerdict& s : verdict.sources) {
    rows.push_back({s.name, shown(s.nis), shown(s.ratio), shown(s.whiteness), fmt::format("{:.1f} %", 100 * s.rejected),
                    std::isnan(s.smoothed) ? "" : shown(s.smoothed), s.holds ? "yes" : "no"});
    for (const std::string& reason : s.reasons) reasons.push_back(fmt::format("{}: {}", s.name, reason));
  }
  for (const PriorJump& jump : verdict.jumps) {
    if (std::abs(jump.sigmas) <= kFarFromPrior) continue;
    reasons.push_back(fmt::format("{} is {:.1f} sigmas from its prior; up to {} may be", jump.name,
                                  std::abs(jump.sigmas), kFarFromPrior));
  }
  std::string out =
      page::list("What decided:", reasons) + page::list("Causes, the most likely first:", verdict.findings);
  if (!rows.empty()) {
    out += page::wide(table("Do the sigmas hold? Under way",
                            {"source", "mean NIS a row (1)", "median NIS, of that of χ² (1)", "correlation (0)",
                             "rejected (0.1 %)", "smoothed residual in sigmas (below 1)", "holds"},
                            rows));
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

// ± the prior of an element of a constant, where it is known.
std::string prior_text(const ReplayReport& report, const BlockInfo& row, int axis) {
  if (report.options == nullptr || row.prior == nullptr) return {};
  return fmt::format(" (prior ± {})", plain(row.factor * row.prior(*report.options)[axis]));
}

std::string estimate_table(const ReplayReport& report) {
  const Solution& solution = page::best_of(report);
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
            i < row.size ? fmt::format("{}: {}{}", row.axes[static_cast<std::size_t>(i)],
                                       measured(value[i] * row.factor, s.blocks[full_offset(block) + i] * row.factor),
                                       prior_text(report, row, i))
                         : "");
      }
      rows.push_back(std::move(cells));
    }
  }
  if (rows.empty()) return {};
  return page::wide(
      table("Estimates at the end, ± 1 sigma (boresight: roll, pitch, heading)", {"block", "", "", ""}, rows));
}

/// Root mean square and largest value of a sigma, with the time of this.
struct Accuracy {
  double square = 0, worst = 0, worst_at = 0;
  void add(double variance, double time) {
    square += variance;
    if (variance <= worst * worst) return;
    worst = std::sqrt(variance);
    worst_at = time;
  }
};

std::string length_text(double metres) {
  constexpr double kMillimetres = 1e3, kCentimetres = 1e2, kLong = 1e4, kShort = 0.01;
  if (metres < kShort) return plain(metres * kMillimetres, 2) + " mm";
  if (metres < 1) return plain(metres * kCentimetres, 2) + " cm";
  return metres < kLong ? plain(metres, 3) + " m" : plain(metres / kMillimetres, 4) + " km";
}

std::string speed_text(double speed) {
  constexpr double kMillimetres = 1e3, kSmall = 0.1;
  return speed < kSmall ? plain(speed * kMillimetres, 2) + " mm/s" : plain(speed, 2) + " m/s";
}

std::string angle_text(double angle) { return plain(angle * kDegreesPerRadian, 2) + "°"; }

// With a number and its unit on one line.
std::string unbroken(std::string text) {
  constexpr std::string_view kNoBreakSpace = "\u00a0";
  for (std::size_t at = text.find(' '); at != std::string::npos; at = text.find(' ', at + 1)) {
    if (at > 0 && std::isdigit(static_cast<unsigned char>(text[at - 1])) != 0 && !text.substr(at).starts_with(" at"))
      text.replace(at, 1, kNoBreakSpace);
  }
  return text;
}

std::vector<std::string> accuracy_tiles(const Solution& solution, double start) {
  std::array<Accuracy, 4> all;
  for (std::size_t i = 0; i < solution.size(); ++i) {
    const NavigationSigmas s = solution.navigation_sigmas(i);
    const double time = solution.time(i) - start;
    all[0].add(s.position.head<2>().squaredNorm(), time);
    all[1].add(square(s.position.z()), time);
    all[2].add(s.velocity.squaredNorm(), time);
    all[3].add(square(s.euler.z()), time);
  }
  std::vector<std::string> out;
  const auto add = [&](std::size_t k, std::string_view name, const auto& text) {
    const double rms = std::sqrt(all[k].square / static_cast<double>(solution.size()));
    out.push_back(page::tile(name, text(rms),
                             unbroken(fmt::format("worst {} at {:.1f} s", text(all[k].worst), all[k].worst_at))));
  };
  add(0, "Horizontal, 1σ rms", length_text);
  add(1, "Height, 1σ rms", length_text);
  add(2, "Velocity, 1σ rms", speed_text);
  add(3, "Heading, 1σ rms", angle_text);
  return out;
}

std::string fixes_tile(const Solution& solution) {
  std::array<std::size_t, kOutcomes.size()> counts{};
  std::size_t used = 0, all = 0;
  for (const Innovation& z : solution.innovations) {
    if (!solution.sources[static_cast<std::size_t>(z.source)].starts_with("gnss")) continue;
    ++all;
    ++counts.at(static_cast<std::size_t>(z.outcome));
    used += was_used(z.outcome) ? 1 : 0;
  }
  std::string left_out;
  for (const Outcome outcome : kOutcomes) {
    const std::size_t count = counts[static_cast<std::size_t>(outcome)];
    if (was_used(outcome) || count == 0) continue;
    left_out += fmt::format("{}{} {}", left_out.empty() ? "" : ", ", count, outcome_name(outcome));
  }
  return page::tile("GNSS measurements used", fmt::format("{} of {}", used, all),
                    left_out.empty() ? "none left out" : left_out);
}

double distance(const Solution& solution) {
  double sum = 0;
  for (std::size_t i = 1; i < solution.size(); ++i) sum += (solution.position(i) - solution.position(i - 1)).norm();
  return sum;
}

/// Whether the sigmas can be relied on, and what to do if not.
std::string reliance(const ReplayReport& report) {
  if (report.verdict == nullptr) return {};
  const Verdict& verdict = *report.verdict;
  if (verdict.consistent) {
    return fmt::format(
        "<p class=\"good\">The stated accuracy can be relied on, as the <strong>sigmas hold</strong>: measurements "
        "scatter "
        "about the track as they say{}.</p>\n",
        verdict.slow_part ? fmt::format(". {}", escape_markup(kInnovationsCannotTell)) : "");
  }
  const bool cautious = has_too_large_sigmas(verdict);
  return fmt::format(
      "<p class=\"{}\"><strong>{}: {}.</strong> Correct this cause, or run <code>tune</code>, and replay again.</p>\n",
      cautious ? "cautious" : "bad",
      cautious ? "The accuracy is better than stated, judged by the measurements"
               : "Do not rely on the stated accuracy",
      escape_markup(verdict_line(verdict)));
}

std::string head(const ReplayReport& report, double start) {
  const Solution& best = page::best_of(report);
  if (best.empty()) return "<p>There is no epoch to show.</p>\n";
  std::vector<std::string> tiles = accuracy_tiles(best, start);
  tiles.push_back(fixes_tile(*report.filtered));
  return reliance(report) + page::tiles(tiles) + page::warnings(report.warnings);
}

/// How many of the run's rows the page has.
std::string rows_shown(const ReplayReport& report) {
  const Solution& best = page::best_of(report);
  if (best.size() < 2) return {};
  const double length = best.time(best.size() - 1) - best.time(0);
  const auto in_files = report.rate > 0 ? static_cast<std::size_t>(length * report.rate) : report.log->imu.size();
  const std::size_t shown = page::shown_rows(best, report.rate).size();
  if (in_files <= kKeptRows) return "Curves hold every row of the files.";
  return fmt::format("Curves hold {} of the {} rows of the files, {:.3g} a second.", shown, in_files,
                     static_cast<double>(shown - 1) / length);
}

// `2022-03-09 11:59:42 UTC · `, or nothing where the week is not known.
std::string date_text(const ReplayReport& report, double start) {
  if (!report.week) return {};
  constexpr std::size_t kDate = 10, kClock = 8;
  const std::string utc = utc_text({*report.week, start});
  return fmt::format("{} {} UTC · ", utc.substr(0, kDate), utc.substr(kDate + 1, kClock));
}

std::string first_screen() {
  return fmt::format("<div class=\"first\">\n{}<div class=\"side\">\n{}{}</div>\n</div>\n", page::plan(),
                     page::place("height"), page::place("speed"));
}

}  // namespace

std::string html_report(const ReplayReport& report) {
  const Solution& best = page::best_of(report);
  const double start = start_of(best), length = best.empty() ? 0 : best.time(best.size() - 1) - start;
  const std::string subtitle =
      fmt::format("{}{} · {} · from time_s {:.3f} · piste {}", date_text(report, start),
                  escape_markup(time_text(length)), length_text(distance(best)), start, escape_markup(report.version));
  const page::Data data = page::replay_data(report);
  const bool charts = page::draws() && !best.empty();
  const std::string over_time = fmt::format(
      "<p class=\"soft\">Bands are ± 1 sigma; rest is shaded{}. {} Drag to zoom, along one axis or both; pinch or "
      "Ctrl and wheel zoom as well; double-click to see all. All charts and the plan share their time.</p>\n",
      report.outages.empty() ? "" : ", withheld GNSS is shaded red", rows_shown(report));
  return page::render(
      {.title = report.title,
       .subtitle = subtitle,
       .head = head(report, start) + (charts ? page::tools() + first_screen() : page::no_charts()),
       .sections = {{"over-time", "Charts", charts ? over_time + page::groups(data) : ""},
                    {"summary", "Summary",
                     (report.verdict != nullptr ? verdict_section(*report.verdict) : "") + "<div class=\"tables\">\n" +
                         log_table(report) + source_table(*report.filtered) + rest_table(*report.log, start) +
                         "</div>\n" + estimate_table(report)},
                    {"config", "Configuration", fmt::format("<pre>{}</pre>\n", escape_markup(report.config_text))}},
       .style = page::styles(),
       .scripts = charts ? page::scripts(data) : ""});
}

}  // namespace piste
