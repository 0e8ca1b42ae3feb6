#include "report/study_bars.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "piste/math/statistics.h"
#include "piste/study/signals.h"

namespace piste::study_bars {

std::vector<std::string> axis_names(const study_words::Triad& triad) {
  const auto first = kSignalNames.begin() + triad.first;
  return {first, first + 3};
}

double bar_offset(std::size_t index, std::size_t count) {
  const double pitch = std::min(0.2, 0.8 / static_cast<double>(count));
  return pitch * (static_cast<double>(index) - 0.5 * (static_cast<double>(count) - 1));
}

void Bars::add(double where, double mean, double half) {
  place.push_back(where);
  value.push_back(mean);
  low.push_back(mean - half);
  high.push_back(mean + half);
}

void Bars::add_truth(double where, double half_stroke, double what) {
  for (const double end : {where - half_stroke, where + half_stroke, kNaN}) {
    truth_place.push_back(end);
    truth.push_back(what);
  }
}

void Bars::draw(Plot& plot, int colour, const std::string& label, Plot::Along along) const {
  const bool along_x = along == Plot::Along::kX;
  plot.bars(along_x ? value : place, along_x ? place : value, low, high, colour, label, along);
}

void Bars::draw_truth(Plot& plot, Plot::Along along) const {
  if (truth.empty()) return;
  const bool along_x = along == Plot::Along::kX;
  plot.line(along_x ? truth : truth_place, along_x ? truth_place : truth, kGrey, "put in");
}

void zero_line(Plot& plot, std::size_t names, Plot::Along along) {
  const std::vector<double> ends{-0.5, static_cast<double>(names) - 0.5}, zero{0, 0};
  const bool along_x = along == Plot::Along::kX;
  plot.line(along_x ? zero : ends, along_x ? ends : zero, kGrey, "", Plot::Stroke::kDotted);
}

std::string bars_caption(const std::vector<AcrossRow>& rows) {
  const auto single = [](const AcrossRow& row) { return row.value.runs == 1; };
  const std::string runs = study_words::runs_of(rows);
  if (std::all_of(rows.begin(), rows.end(), single)) return "Bars: 95 % interval of one run, by the error within it. ";
  std::string out = fmt::format("Bars: 95 % interval of the mean over {}, by the standard error between runs", runs);
  if (std::any_of(rows.begin(), rows.end(), single)) out += ", and of one run by the error within it";
  return out + ". ";
}

std::string truth_caption(const Study& study) {
  return study.simulated ? " Short strokes: what was put in, as this method could see it." : "";
}

void append(std::vector<Figure>& out, std::optional<Figure> figure) {
  if (figure) out.push_back(std::move(*figure));
}

}  // namespace piste::study_bars
