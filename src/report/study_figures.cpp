#include "piste/report/study_figures.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <iterator>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "piste/math/statistics.h"
#include "piste/math/units.h"
#include "piste/study/ranking.h"
#include "piste/study/study_tables.h"
#include "plot/svg.h"
#include "report/study_bars.h"
#include "report/study_words.h"
#include "study/printed_tables.h"

namespace piste {
namespace {

using study_bars::append;
using study_bars::bar_offset;
using study_bars::Bars;
using study_bars::kFrame;
using study_bars::kGrey;
using study_bars::kHeight;
using study_bars::kSign;
using study_words::at;
using study_words::by_score;
using study_words::kTriads;
using study_words::Triad;

std::optional<Figure> delays(const std::vector<TimingRow>& rows, const PrintedTable* scales, const Triad& triad) {
  if (rows.empty()) return {};
  Plot plot(fmt::format("What a residual delay does to the scale of the {}", triad.name),
            {"delay of the reference [ms]"}, {"change of scale' [ratio]"});
  plot.size(Plot::kPageWidth, kHeight + 60);
  std::vector<double> delay;
  delay.reserve(rows.size());
  for (const TimingRow& row : rows) delay.push_back(kMillisecondsPerSecond * row.delay);
  for (int i = 0; i < 3; ++i) {
    const std::size_t axis = at(triad.first + i);
    const auto draw = [&](std::array<double, kSignals> TimingRow::*values,
                          std::array<double, kSignals> TimingRow::*errors, std::string_view direction,
                          Plot::Stroke stroke) {
      Bars bars;
      for (std::size_t k = 0; k < rows.size(); ++k)
        bars.add(delay[k], (rows[k].*values)[axis], (rows[k].*errors)[axis]);
      plot.line(bars.place, bars.value, i, fmt::format("{} {}", kSignalNames[axis], direction), stroke);
      bars.draw(plot, i, "", Plot::Along::kY);
    };
    draw(&TimingRow::forward, &TimingRow::forward_error, "forward", Plot::Stroke::kSolid);
    draw(&TimingRow::reverse, &TimingRow::reverse_error, "reverse", Plot::Stroke::kDashed);
    if (!scales) continue;
    const double printed = axis_mean(*scales, triad.first + i);
    plot.line({delay.front(), delay.back()}, {printed, printed}, i,
              fmt::format("{} in the article", kSignalNames[axis]), Plot::Stroke::kDotted);
  }
  std::string caption =
      "Mean over sensors and runs of scale' at that delay less scale' at none; bars: one standard error between runs. "
      "Forward is the regression of the reference on the IMU; a delay drives the two directions apart. ";
  if (scales) caption += fmt::format("Dotted: mean over the sensors of the article's {}. ", scales->name);
  return as_figure(fmt::format("timing_{}", triad.stem), std::move(plot), caption + std::string(kSign));
}

std::vector<std::string> titles(const std::vector<RankingRow>& rows) {
  std::vector<std::string> out;
  out.reserve(rows.size());
  for (const RankingRow& row : rows) out.emplace_back(info(row.method).title);
  return out;
}

Figure scores(const std::vector<RankingRow>& rows, const Ranking& ranking) {
  Plot plot("Which estimate gives the best navigation?", {"score over the lowest [ratio]", {}, true},
            {"method", {}, false, titles(rows)});
  plot.size(Plot::kPageWidth, static_cast<int>(24 * rows.size()) + kFrame);
  const auto draw = [&](int colour, const char* label, const auto& chosen) {
    Bars bars;
    for (std::size_t i = 0; i < rows.size(); ++i) {
      if (!chosen(rows[i].method)) continue;
      bars.place.push_back(static_cast<double>(i));
      bars.value.push_back(rows[i].versus_winner);
      bars.low.push_back(rows[i].low);
      bars.high.push_back(rows[i].high);
    }
    if (!bars.place.empty()) bars.draw(plot, colour, label, Plot::Along::kX);
  };
  const std::vector<RankingRow> first = leaders(ranking);
  const auto wins = [&](Method m) {
    return std::ranges::any_of(first, [m](const RankingRow& row) { return row.method == m; });
  };
  draw(2, has_winner(ranking) ? "winner" : first.size() > 1 ? "tie for the best" : "lowest score", wins);
  draw(0, "competes", [&](Method m) { return info(m).competes && !wins(m); });
  draw(kGrey, "for comparison", [](Method m) { return !info(m).competes; });
  return {
      "ranking", plot.render(),
      "Score: geometric mean of the errors of position, velocity and attitude and of the drift without GNSS, each "
      "over that of a replay that knows nothing. Bars: 95 % interval of the ratio to the lowest score, paired by run."};
}

std::optional<Figure> metrics(const std::vector<RankingRow>& rows) {
  const auto nothing =
      std::find_if(rows.begin(), rows.end(), [](const RankingRow& row) { return row.method == Method::kNothing; });
  if (nothing == rows.end()) return {};
  Plot plot("The four errors that make the score", {"error over that of knowing nothing [ratio]", {}, true},
            {"method", {}, false, titles(rows)});
  plot.size(Plot::kPageWidth, static_cast<int>(34 * rows.size()) + kFrame);
  constexpr std::array<std::pair<double RankingRow::*, const char*>, 4> kMetrics{
      {{&RankingRow::position_rmse, "position"},
       {&RankingRow::velocity_rmse, "velocity"},
       {&RankingRow::attitude_rmse, "attitude"},
       {&RankingRow::outage_drift, "drift without GNSS"}}};
  for (std::size_t m = 0; m < kMetrics.size(); ++m) {
    Bars dots;
    for (std::size_t i = 0; i < rows.size(); ++i) {
      const double ratio = rows[i].*kMetrics[m].first / *nothing.*kMetrics[m].first;
      dots.add(static_cast<double>(i) + bar_offset(m, kMetrics.size()), ratio, kNaN);
    }
    dots.draw(plot, static_cast<int>(m), kMetrics[m].second, Plot::Along::kX);
  }
  return Figure{"ranking_metrics", plot.render(),
                "Root mean square over sensors and runs, over that of the replay that knows nothing; the numbers with "
                "their units stand in Table 7."};
}

}  // namespace

std::vector<Figure> study_timing(const Study& study) {
  const std::vector<TimingRow> rows = timing(study);
  const bool printed = study.article && !study.article->article.tables.joint_scale.empty();
  const PrintedTable* scales = printed ? &study.article->article.tables.joint_scale : nullptr;
  std::vector<Figure> out;
  for (const Triad& triad : kTriads) append(out, delays(rows, scales, triad));
  return out;
}

std::vector<Figure> study_ranking(const Study& study) {
  const Ranking all = ranking(study);
  if (all.rows.empty()) return {};
  const std::vector<RankingRow> rows = by_score(all);
  std::vector<Figure> out{scores(rows, all)};
  append(out, metrics(rows));
  return out;
}

std::vector<Figure> study_figures(const Study& study) {
  std::vector<Figure> out;
  for (const auto of : {study_signals, study_estimates, study_comparisons, study_correlations, study_truth,
                        study_timing, study_ranking}) {
    std::vector<Figure> more = of(study);
    std::move(more.begin(), more.end(), std::back_inserter(out));
  }
  return out;
}

}  // namespace piste
