#include "piste/report/tuning_page.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "math/words.h"
#include "piste/math/statistics.h"
#include "plot/markup.h"
#include "plot/svg.h"
#include "plot/svg_frame.h"
#include "report/page.h"

namespace piste {
namespace {

constexpr std::string_view kHowToReadTuning =
    R"(<p>The <strong>likelihood</strong> of the innovations is that of what the receivers and the reference measured, given the noise
that is stated. <code>tune</code> seeks the noise for which it is largest, together with a weak <strong>prior</strong> about what
was stated.</p>
<p>The <strong>interval</strong> holds a number with 95 %, by likelihood and prior together. A number is <strong>determined</strong> if
the data halve the prior's sigma at least and the interval is within a factor of 3; the others stay near what was stated.</p>
<p><strong>NIS</strong> of each source should be 1 within its error: then the sigmas of its innovations are true.</p>
)";

/// Each number over what it was before, with its interval. Empty if there is none.
std::string intervals(const Tuning& tuning) {
  std::vector<double> of[2], low[2], high[2], at[2];
  std::vector<std::string> names;
  constexpr double kRowHeight = 26, kMargin = 110;
  double least = 1, most = 1;
  for (const TunedNoise& n : tuning.numbers) {
    if (!(n.start > 0 && n.value > 0)) continue;
    const std::size_t kind = n.determined ? 0 : 1;
    of[kind].push_back(n.value / n.start);
    low[kind].push_back(n.low / n.start);
    high[kind].push_back(n.high / n.start);
    at[kind].push_back(static_cast<double>(names.size()));
    for (const double value : {n.value / n.start, n.low / n.start, n.high / n.start}) {
      if (!(value > 0) || !std::isfinite(value)) continue;
      least = std::min(least, value);
      most = std::max(most, value);
    }
    names.push_back(n.name);
  }
  if (names.empty()) return {};
  constexpr double kRoom = 1.2, kFurthest = 1e3;
  Plot plot("Maximum-likelihood noise over what was stated", {.label = "factor", .log = true},
            {.label = "", .names = names}, "Each number over what was stated, with its 95 % interval");
  plot.size(Plot::kPageWidth, static_cast<int>(kMargin + kRowHeight * static_cast<double>(names.size())));
  plot.limit_x(std::max(least, 1 / kFurthest) / kRoom, std::min(most, kFurthest) * kRoom);
  plot.line({1, 1}, {-0.5, static_cast<double>(names.size()) - 0.5}, svg::kInk, "as stated", Plot::Stroke::kDashed);
  if (!of[0].empty()) plot.bars(of[0], at[0], low[0], high[0], 0, "determined", Plot::Along::kX);
  if (!of[1].empty()) plot.bars(of[1], at[1], low[1], high[1], 6, "not determined by the data", Plot::Along::kX);
  return page::pictures({{"noise", plot.render(), "Each number over what was stated before, with its 95 % interval."}});
}

// The 95 % interval of a number before any data.
std::string prior_text(const TunedNoise& n) {
  if (!(n.prior > 0 && n.start > 0)) return {};
  const double reach = std::exp(n.prior * normal_quantile(0.975));
  return fmt::format("{} to {}", plain(n.start / reach), plain(n.start * reach));
}

std::string numbers(const Tuning& tuning) {
  std::vector<page::Row> rows;
  for (const TunedNoise& n : tuning.numbers) {
    rows.push_back({n.name, n.unit.empty() ? "factor" : n.unit, plain(n.start), prior_text(n), plain(n.value),
                    fmt::format("{} to {}", plain(n.low), plain(n.high)), n.determined ? "yes" : "no"});
  }
  return page::wide(
      page::table("", {"number", "unit", "before", "prior, 95 %", "estimate", "95 %", "determined"}, rows));
}

std::string sources(const Tuning& tuning) {
  std::vector<page::Row> rows;
  for (const SourceNis& s : tuning.nis) {
    rows.push_back({s.source, fmt::format("{}", s.innovations), fmt::format("{:.2f} ± {:.2f}", s.mean, s.error)});
  }
  const std::string caption = tuning.held_out > 0 ? "Of the stretches that were held out" : "";
  return page::table(caption, {"source", "innovations", "mean NIS a row (1)"}, rows);
}

std::string head(const Tuning& tuning) {
  const auto determined = std::ranges::count_if(tuning.numbers, [](const TunedNoise& n) { return n.determined; });
  std::vector<std::string> tiles{
      page::tile("Likelihood gained", fmt::format("{:.1f}", tuning.likelihood - tuning.likelihood_at_start),
                 fmt::format("ln L, over {} rows of innovations", tuning.rows)),
      page::tile("Numbers determined", fmt::format("{} of {}", determined, tuning.numbers.size()),
                 fmt::format("by {} runs of the filter", tuning.filter_runs))};
  if (tuning.drift_gain) {
    const bool kept = *tuning.drift_gain > tuning.drift_penalty;
    tiles.push_back(
        page::tile("Slow error of the receiver", kept ? "kept" : "not kept",
                   fmt::format("ln L gains {:.1f}; {:.1f} is its penalty", *tuning.drift_gain, tuning.drift_penalty)));
  }
  return page::tiles(tiles);
}

}  // namespace

std::string tuning_page(const Tuning& tuning, const std::string& title, const std::string& sensor_file,
                        const std::string& version) {
  return page::render(
      {.title = title,
       .subtitle = fmt::format("piste {} · maximum-likelihood noise of a run in motion", escape_markup(version)),
       .head = head(tuning),
       .sections = {{"numbers", "Numbers", intervals(tuning) + numbers(tuning)},
                    {"sources", "Innovations with them", sources(tuning)},
                    {"sensor", "Sensor file", fmt::format("<pre>{}</pre>\n", escape_markup(sensor_file))},
                    {"reading", "How to read it", std::string(kHowToReadTuning)}}});
}

}  // namespace piste
