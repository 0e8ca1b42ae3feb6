#include "piste/report/consistency_page.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>

#include "consistency/report_numbers.h"
#include "piste/math/units.h"
#include "plot/markup.h"
#include "plot/svg.h"
#include "report/drawing.h"
#include "report/page.h"

namespace piste {
namespace {

using page::Row;
using page::table;

enum TrendColour { kSmootherColour, kFilterColour, kTurnColour = 4, kAtRestColour = 5, kBandColour = 6 };
constexpr int kTrendHeight = 330;  // px

constexpr std::array<std::string_view, kPhaseNames.size()> kPhaseTitles{"At rest before the start", "Under way",
                                                                        "At rest after the stop"};
constexpr std::array kPhaseOrder{Phase::kUnderWay, Phase::kRest, Phase::kRestAfter};

constexpr std::string_view kHowToReadConsistency =
    R"(<p><strong>NEES</strong> is the squared error in units of the covariance that is claimed of it, per state: 1 where the
covariance is true. Above the band the sigmas are too small, below it they are too large; the band is that of a mean over the runs
at one epoch, so the mean over a whole phase keeps to it the more easily.</p>
<p><strong>The bound</strong> (posterior Cramér-Rao) is the smallest error that any estimator can have on average: the covariance
of the same filter and smoother linearised at the truth. RMSE over bound is 1 where no estimator can be better. The claimed
sigma next to it is the RMSE that the estimator itself expects.</p>
<p><strong>Coverage</strong> is the share of single errors within 1, 2 and 3 of their own sigmas. True sigmas of normal errors
give .683, .954 and .997; a smaller last share means errors that are rare but large.</p>
<p><strong>NIS</strong> is to an innovation what NEES is to an error, gated ones counted in. Of a true filter successive
innovations are uncorrelated; where they are not, an error lasts that no state describes.</p>
)";

/// Filter and smoother with their names, if they have any results.
std::vector<std::pair<std::string, const EstimatorConsistency*>> estimators(const ConsistencyReport& report) {
  std::vector<std::pair<std::string, const EstimatorConsistency*>> out;
  for (const auto& [name, e] : {std::pair{"filter", &report.filter}, {"smoother", &report.smoother}}) {
    const bool seen = std::any_of(e->groups.begin(), e->groups.end(), [](const auto& phase) { return !phase.empty(); });
    if (seen) out.emplace_back(name, e);
  }
  return out;
}

int colour_of(const std::string& estimator) { return estimator == "filter" ? kFilterColour : kSmootherColour; }

// ---- Pictures ----

/// A picture over the time of the grid, with its phases. The scale is that of the values under way.
class TimePlot {
 public:
  TimePlot(const EpochGrid& grid, const std::string& title, const std::string& unit, const std::string& description)
      : grid_(grid),
        plot_(title, {"time after the departure [s]"}, {unit}, description),
        caption_(fmt::format("{}.", description)) {
    for (int epoch = grid.first; epoch <= grid.last; ++epoch) time_.push_back(grid.time(epoch));
    plot_.size(Plot::kPageWidth, kTrendHeight);
  }

  void band(const Band& band, const std::string& label) {
    plot_.band({time_.front(), time_.back()}, {band.low, band.low}, {band.high, band.high}, kBandColour, label);
    cover(band.low);
    cover(band.high);
  }

  void line(std::vector<double> values, int colour, std::string label, Plot::Stroke stroke = Plot::Stroke::kSolid) {
    for (std::size_t i = 0; i < values.size(); ++i) {
      if (grid_.phase(time_[i]) == Phase::kUnderWay) cover(values[i]);
    }
    plot_.line(time_, std::move(values), colour, std::move(label), stroke);
  }

  /// With a margin of half the range on each side; `from_zero` starts the scale at zero.
  Figure figure(std::string name, bool from_zero) {
    shade(time_.front(), 0, kAtRestColour, "at rest");
    shade(grid_.arrival, time_.back(), kAtRestColour, "");
    shade(0, grid_.cruise.start, kTurnColour, "starting, stopping");
    shade(grid_.cruise.end, grid_.arrival, kTurnColour, "");
    if (low_ < high_) {
      const double room = 0.5 * (high_ - (from_zero ? 0 : low_));
      plot_.limit_y(from_zero ? 0 : std::max(0.0, low_ - room), high_ + room);
    }
    return as_figure(std::move(name), std::move(plot_), caption_);
  }

 private:
  void shade(double from, double to, int colour, const std::string& label) {
    from = std::max(from, time_.front());
    to = std::min(to, time_.back());
    if (from < to) plot_.shade(from, to, colour, label);
  }
  void cover(double value) {
    if (!std::isfinite(value)) return;
    low_ = std::min(low_, value);
    high_ = std::max(high_, value);
  }

  const EpochGrid& grid_;
  Plot plot_;
  std::string caption_;
  std::vector<double> time_;
  double low_ = std::numeric_limits<double>::infinity(), high_ = -std::numeric_limits<double>::infinity();
};

std::vector<Figure> nees_plots(const ConsistencyReport& report) {
  std::vector<Figure> out;
  for (std::size_t g = 0; g < report.groups.size(); ++g) {
    const StateGroup& group = report.groups[g];
    const auto& blocks = report.layout.blocks();
    const bool single = std::any_of(blocks.begin(), blocks.end(), [&](Block b) { return info(b).name == group.name; });
    if (single) continue;  // its numbers are in the table
    TimePlot plot(report.grid, fmt::format("NEES per state: {} ({} states)", group.name, group.rows.size()), "NEES",
                  fmt::format("NEES of {} over time, filter and smoother, with its band", group.name));
    plot.band(report.bands[g], percent(report.probability) + " band");
    for (const auto& [name, e] : estimators(report)) plot.line(e->nees[g], colour_of(name), name);
    out.push_back(plot.figure("nees_" + group.name, false));
  }
  return out;
}

std::vector<double> over_time(const std::vector<BlockAccuracy>& accuracy, double BlockAccuracy::*term, double factor) {
  std::vector<double> out;
  out.reserve(accuracy.size());
  for (const BlockAccuracy& at : accuracy) out.push_back(factor * at.*term);
  return out;
}

std::vector<Figure> accuracy_plots(const ConsistencyReport& report) {
  std::vector<Figure> out;
  const auto& blocks = report.layout.blocks();
  for (std::size_t b = 0; b < blocks.size(); ++b) {
    if (!is_navigation(blocks[b])) continue;
    const BlockInfo& row = info(blocks[b]);
    TimePlot plot(report.grid, fmt::format("RMSE of {}, three axes together", row.name), fmt::format("[{}]", row.unit),
                  fmt::format("RMSE of {} over time against its bound and the claimed sigma", row.name));
    for (const auto& [name, e] : estimators(report)) {
      const auto line = [&, &label = name, &errors = e](double BlockAccuracy::*term, const char* what,
                                                        Plot::Stroke stroke) {
        plot.line(over_time(errors->accuracy[b], term, row.factor), colour_of(label), label + what, stroke);
      };
      line(&BlockAccuracy::rmse, " RMSE", Plot::Stroke::kSolid);
      line(&BlockAccuracy::bound, " bound", Plot::Stroke::kDashed);
      line(&BlockAccuracy::claimed, " claimed", Plot::Stroke::kDotted);
    }
    out.push_back(plot.figure(fmt::format("rmse_{}", row.name), true));
  }
  if (std::all_of(blocks.begin(), blocks.end(), is_navigation)) return out;
  for (const auto& [name, e] : estimators(report)) {
    TimePlot plot(report.grid, fmt::format("RMSE over its bound, {}: the other blocks", name), "RMSE / bound",
                  fmt::format("RMSE over its bound over time, {}, of the blocks beyond navigation", name));
    int colour = 0;
    for (std::size_t b = 0; b < blocks.size(); ++b) {
      if (is_navigation(blocks[b])) continue;
      plot.line(over_time(e->accuracy[b], &BlockAccuracy::ratio, 1), colour++, std::string(info(blocks[b]).name));
    }
    out.push_back(plot.figure("rmse_over_bound_" + name, false));
  }
  return out;
}

// ---- Tables ----

std::string with_error(double value, double standard_error) {
  return std::isfinite(standard_error) ? fmt::format("{:.3f} ± {:.3f}", value, standard_error)
                                       : fmt::format("{:.3f}", value);
}

std::string nees_table(const ConsistencyReport& report, Phase phase, std::string_view caption) {
  const auto p = static_cast<std::size_t>(phase);
  Row head{"group", "states", percent(report.probability) + " band"};
  const auto all = estimators(report);
  for (const auto& [name, e] : all) {
    head.push_back(name + " NEES");
    head.push_back("± s.e.");
    head.push_back("epochs outside");
  }
  std::vector<Row> rows;
  for (std::size_t g = 0; g < report.groups.size(); ++g) {
    Row row{report.groups[g].name, fmt::format("{}", report.groups[g].rows.size()), band_text(report.bands[g])};
    for (const auto& [name, e] : all) {
      if (e->groups[p].empty()) {
        row.insert(row.end(), 3, "");
        continue;
      }
      const GroupConsistency& found = e->groups[p][g];
      row.push_back(starred(found.nees, found.test));
      row.push_back(std::isfinite(found.standard_error) ? fmt::format("{:.3f}", found.standard_error) : "");
      row.push_back(fmt::format("{:.1f} %", 100 * found.outside));
    }
    rows.push_back(std::move(row));
  }
  return table(caption, head, rows);
}

std::string coverage_table(const ConsistencyReport& report) {
  constexpr auto kSeen = static_cast<std::size_t>(Phase::kUnderWay);
  Row head{"group"}, normal{"normal errors"};
  std::vector<Row> rows{{}};
  for (const auto& [name, e] : estimators(report)) {
    for (const char* what : {" 1σ", " 2σ", " 3σ", " largest"}) head.push_back(name + what);
    for (const char* share : {".683", ".954", ".997", ""}) normal.emplace_back(share);
  }
  rows.front() = std::move(normal);
  for (std::size_t g = 0; g < report.groups.size(); ++g) {
    Row row{report.groups[g].name};
    for (const auto& [name, e] : estimators(report)) {
      if (e->groups[kSeen].empty()) {
        row.insert(row.end(), 4, "");
        continue;
      }
      const GroupConsistency& found = e->groups[kSeen][g];
      for (const double share : found.coverage) row.push_back(fmt::format("{:.3f}", share));
      row.push_back(fmt::format("{:.1f} σ, seed {}", found.largest, found.largest_seed));
    }
    rows.push_back(std::move(row));
  }
  return table("Share of single errors within 1, 2 and 3 sigma, under way", head, rows);
}

std::string accuracy_table(const ConsistencyReport& report, const EstimatorConsistency& estimator,
                           const std::string& name, Phase phase) {
  const auto& found = estimator.blocks[static_cast<std::size_t>(phase)];
  if (found.empty()) return {};
  std::vector<Row> rows;
  for (std::size_t b = 0; b < found.size(); ++b) {
    const BlockInfo& block = info(report.layout.blocks()[b]);
    Row row{fmt::format("{} [{}]", block.name, block.unit)};
    for (const double value : {found[b].rmse, found[b].bound, found[b].claimed}) {
      row.push_back(fmt::format("{:.4g}", block.factor * value));
    }
    row.push_back(with_error(found[b].ratio, found[b].standard_error));
    rows.push_back(std::move(row));
  }
  return table(fmt::format("RMSE, {}", name), {"block", "RMSE", "bound", "claimed", "RMSE / bound"}, rows);
}

std::string phase_tables(const ConsistencyReport& report) {
  std::string out;
  for (const Phase phase : kPhaseOrder) {
    const auto p = static_cast<std::size_t>(phase);
    const auto interval = report.grid.interval(phase);
    if (!interval || (report.filter.groups[p].empty() && report.smoother.groups[p].empty())) continue;
    out +=
        fmt::format("<h3>{} <small>{:.6g} to {:.6g} s</small></h3>\n", kPhaseTitles[p], interval->start, interval->end);
    out += nees_table(report, phase, "NEES per state; * the mean is not 1; band of one epoch") +
           "<div class=\"tables\">\n";
    for (const auto& [name, e] : estimators(report)) out += accuracy_table(report, *e, name, phase);
    out += "</div>\n";
  }
  return out;
}

std::string source_table(const ConsistencyReport& report) {
  if (report.sources.empty()) return "<p>No measurement came under way.</p>\n";
  std::vector<Row> rows;
  for (const SourceConsistency& s : report.sources) {
    const std::vector<double> axes(s.autocorrelation.begin(), s.autocorrelation.begin() + s.dof);
    rows.push_back({s.name, fmt::format("{}", s.dof), fmt::format("{}", s.count), fmt::format("{}", s.rejected),
                    starred(s.nis, s.test), band_text(s.band),
                    fmt::format("{:.3f}{}", fmt::join(axes, ", "), s.white() ? "" : "*"),
                    fmt::format("± {:.3f}", s.autocorrelation_band)});
  }
  return table("Under way; * the mean is not 1, or innovations are correlated",
               {"source", "rows", "count", "rejected", "NIS per row", "band", "correlation of successive ones, by axis",
                "band if white"},
               rows);
}

/// Groups whose NEES is not 1 before the start or after the stop.
std::vector<std::string> outside_at_rest(const ConsistencyReport& report) {
  std::vector<std::string> out;
  for (const auto& [name, e] : estimators(report)) {
    for (std::size_t g = 0; g < report.groups.size(); ++g) {
      for (const Phase phase : {Phase::kRest, Phase::kRestAfter}) {
        const auto& found = e->groups[static_cast<std::size_t>(phase)];
        if (found.empty() || found[g].test.holds) continue;
        out.push_back(fmt::format("{} {} ({:.2f})", name, report.groups[g].name, found[g].nees));
      }
    }
  }
  return out;
}

std::string verdict(const ConsistencyReport& report) {
  std::string out = fmt::format("<p><strong>{}</strong></p>\n", escape_markup(consistency_verdict(report)));
  std::vector<std::string> nis, coloured;
  for (const SourceConsistency& s : report.sources) {
    if (!s.test.holds) nis.push_back(escape_markup(s.name));
    if (!s.white()) coloured.push_back(escape_markup(s.name));
  }
  if (const auto outside = outside_at_rest(report); report.consistent() && !outside.empty()) {
    out += fmt::format("<p>At rest the NEES is not 1 of: {}. The verdict is that of the time under way alone.</p>\n",
                       escape_markup(fmt::format("{}", fmt::join(outside, ", "))));
  }
  if (report.consistent() && (!nis.empty() || !coloured.empty())) {
    out += "<p>The verdict is that of the errors (NEES). Innovations are stated for the search of causes:</p>\n";
  }
  if (!nis.empty()) out += fmt::format("<p>The NIS is not 1 at: {}.</p>\n", fmt::join(nis, ", "));
  if (!coloured.empty()) out += fmt::format("<p>Innovations are not white at: {}.</p>\n", fmt::join(coloured, ", "));
  if (const HeadingFound& h = report.heading; h.runs > 0) {
    out += fmt::format(
        "<p>Heading {:.4g} s after the departure, filter, over {} runs: RMSE {:.3g} deg, largest error {:.3g} deg, "
        "largest "
        "sigma {:.3g} deg, largest error in sigmas {:.1f}.</p>\n",
        h.time, h.runs, kDegreesPerRadian * h.rmse, kDegreesPerRadian * h.largest, kDegreesPerRadian * h.largest_sigma,
        h.largest_ratio);
  }
  return out;
}

std::string failure_table(const ConsistencyReport& report) {
  if (report.failures.empty()) return "<p>None.</p>\n";
  std::string out = "<ul>\n";
  for (const FailedRun& f : report.failures)
    out += fmt::format("<li>seed {}: {}</li>\n", f.seed, escape_markup(f.what));
  return out + "</ul>\n";
}

}  // namespace

std::string consistency_html(const ConsistencyReport& report, const std::string& title, const std::string& version,
                             const std::string& scenario_text) {
  const std::string subtitle =
      fmt::format("piste {} · {} simulated runs with known truth; times count from the departure",
                  escape_markup(version), report.runs);
  page::Drawing drawing;
  const std::string nees = drawing.add(nees_plots(report)), accuracy = drawing.add(accuracy_plots(report));
  return page::render(
      {.title = title,
       .subtitle = subtitle,
       .head = drawing.head(),
       .sections = {{"verdict", "Verdict", verdict(report)},
                    {"nees", "NEES over time",
                     "<p class=\"soft\">Mean over the runs at each epoch. The scale is that of the stretch under way; "
                     "what lies far beyond is cut off. Blue: at rest; grey: starting and stopping.</p>\n" +
                         nees},
                    {"accuracy", "Errors over time", accuracy},
                    {"coverage", "Coverage", coverage_table(report)},
                    {"phases", "By phase", phase_tables(report)},
                    {"innovations", "Innovations", source_table(report)},
                    {"failures", "Failed runs", failure_table(report)},
                    {"reading", "How to read it", std::string(kHowToReadConsistency)},
                    {"scenario", "Scenario", fmt::format("<pre>{}</pre>\n", escape_markup(scenario_text))}},
       .style = drawing.style(),
       .scripts = drawing.scripts()});
}

}  // namespace piste
