#include "piste/report/study_figures.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <limits>
#include <optional>
#include <string>
#include <string_view>
#include <utility>

#include "piste/experiment/study_tables.h"
#include "piste/plot/heat_map.h"
#include "piste/plot/svg.h"
#include "piste/plot/thin.h"
#include "report/study_text.h"

namespace piste {
namespace {

using study_text::band_of;
using study_text::by_score;
using study_text::half_width;
using study_text::kTriads;
using study_text::Triad;

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
constexpr int kWidth = 980, kHeight = 340;
constexpr int kFrame = 150;  // [px] of a picture's height that rows of names do not have
constexpr std::size_t kPoints = 3000;
constexpr double kMilliseconds = 1e3;
constexpr int kGrey = 6;
constexpr std::string_view kSign = "Article's sign: a correction to add.";

std::size_t at(int i) { return static_cast<std::size_t>(i); }

std::vector<std::string> axis_names(const Triad& triad) {
  const auto first = kSignalNames.begin() + triad.first;
  return {first, first + 3};
}

/// Place of one of `count` things that share a name.
double beside(std::size_t index, std::size_t count) {
  const double pitch = std::min(0.2, 0.8 / static_cast<double>(count));
  return pitch * (static_cast<double>(index) - 0.5 * (static_cast<double>(count) - 1));
}

/// Numbers with their 95 % intervals, at places along the other axis; and what is true of them.
struct Bars {
  std::vector<double> place, value, low, high;
  std::vector<double> truth_place, truth;  ///< short strokes

  void add(double where, double mean, double half) {
    place.push_back(where);
    value.push_back(mean);
    low.push_back(mean - half);
    high.push_back(mean + half);
  }
  void add_truth(double where, double half_stroke, double what) {
    for (const double end : {where - half_stroke, where + half_stroke, kNaN}) {
      truth_place.push_back(end);
      truth.push_back(what);
    }
  }
  void draw(Plot& plot, int colour, const std::string& label, Plot::Along along) const {
    const bool along_x = along == Plot::Along::kX;
    plot.bars(along_x ? value : place, along_x ? place : value, low, high, colour, label, along);
  }
  void draw_truth(Plot& plot, Plot::Along along) const {
    if (truth.empty()) return;
    const bool along_x = along == Plot::Along::kX;
    plot.line(along_x ? truth : truth_place, along_x ? truth_place : truth, kGrey, "put in");
  }
};

/// Where an interval does or does not cut it.
void zero_line(Plot& plot, std::size_t names, Plot::Along along) {
  const std::vector<double> ends{-0.5, static_cast<double>(names) - 0.5}, zero{0, 0};
  const bool along_x = along == Plot::Along::kX;
  plot.line(along_x ? zero : ends, along_x ? ends : zero, kGrey, "", Plot::Stroke::kDotted);
}

std::string bars_caption(const std::vector<AcrossRow>& rows) {
  const auto single = [](const AcrossRow& row) { return row.value.runs == 1; };
  const std::string runs = study_text::runs_of(rows);
  if (std::all_of(rows.begin(), rows.end(), single)) return "Bars: 95 % interval of one run, by the error within it. ";
  std::string out = fmt::format("Bars: 95 % interval of the mean over {}, by the standard error between runs", runs);
  if (std::any_of(rows.begin(), rows.end(), single)) out += ", and of one run by the error within it";
  return out + ". ";
}

std::string truth_caption(const Study& study) {
  return study.simulated ? " Short strokes: what was put in, as this method could see it." : "";
}

// ---- Signals ----

const SensorRun* pictured(const Study& study) {
  for (const SensorRun& r : study.results) {
    if (r.picture && !r.picture->time.empty()) return &r;
  }
  return nullptr;
}

struct Curve {
  std::vector<double> x, y;
};

/// `values` at `time` less its first, inside `window`, with fewer points for the same picture.
template <class Value>
Curve curve(const std::vector<double>& time, const std::optional<Interval>& window, const Value& value) {
  Curve all, out;
  for (std::size_t i = 0; i < time.size(); ++i) {
    if (window && !window->contains(time[i])) continue;
    all.x.push_back(time[i] - time.front());
    all.y.push_back(value(i));
  }
  const std::array columns{all.y};
  for (const std::size_t i : thin(columns, kPoints)) {
    out.x.push_back(all.x[i]);
    out.y.push_back(all.y[i]);
  }
  return out;
}

/// Mean and standard deviation of what is finite.
std::array<double, 2> moments(const std::vector<double>& values) {
  double sum = 0, squares = 0, n = 0;
  for (const double v : values) {
    if (!std::isfinite(v)) continue;
    sum += v;
    squares += v * v;
    ++n;
  }
  const double mean = n > 0 ? sum / n : 0;
  return {mean, n > 0 ? std::sqrt(std::max(0.0, squares / n - mean * mean)) : 0};
}

/// The axis of a triad that the motion drives most.
int liveliest(const SignalPicture& picture, const Triad& triad) {
  const auto spread = [&](int axis) { return moments(picture.reference[at(axis)])[1]; };
  int best = triad.first;
  for (int axis = triad.first + 1; axis < triad.first + 3; ++axis) {
    if (spread(axis) > spread(best)) best = axis;
  }
  return best;
}

constexpr std::string_view kTimeLabel = "GPS time after the first sample [s]";

std::string who(const Study& study, const SensorRun& r) {
  return fmt::format("{}, {}", study.sensors[r.sensor], study.runs[r.run].name);
}

Figure whole_signal(const Study& study, const SensorRun& r, const Triad& triad) {
  const SignalPicture& p = *r.picture;
  const int axis = liveliest(p, triad);
  const double factor = signal_info(axis).factor;
  Plot plot(fmt::format("Figure 7. {} of {}: rest, run and rest", kSignalNames[at(axis)], who(study, r)),
            {std::string(kTimeLabel)}, {fmt::format("{} [{}]", kSignalNames[at(axis)], triad.unit)});
  plot.size(kWidth, kHeight);
  const Phases& phases = study.runs[r.run].phases;
  const auto shade = [&](const std::optional<Interval>& phase, int colour, const char* label) {
    if (phase) plot.shade(phase->start - p.time.front(), phase->end - p.time.front(), colour, label);
  };
  shade(phases.before, 2, "rest before");
  shade(phases.run, 4, "run");
  shade(phases.after, 3, "rest after");
  const auto draw = [&](const std::vector<double>& series, int colour, const char* label, Plot::Stroke stroke) {
    const Curve c = curve(p.time, {}, [&](std::size_t i) { return factor * series[i]; });
    plot.line(c.x, c.y, colour, label, stroke);
  };
  draw(p.measured[at(axis)], 0, "IMU", Plot::Stroke::kSolid);
  draw(p.reference[at(axis)], 1, "reference, turned and moved", Plot::Stroke::kSolid);
  return {fmt::format("figure_07_{}", triad.stem), plot.render(),
          fmt::format("The axis of the {} that the motion drives most, {}, beside the reference; the three phases are "
                      "shaded.",
                      triad.name, band_of(study))};
}

Figure at_rest(const Study& study, const SensorRun& r, const Triad& triad, bool after) {
  const SignalPicture& p = *r.picture;
  const Phases& phases = study.runs[r.run].phases;
  const auto& window = after ? phases.after : phases.before;
  Plot plot(fmt::format("Figure {}. At rest {} the {}: reference less IMU, {}", after ? 10 : 9,
                        after ? "after" : "before", after ? "stop" : "start", who(study, r)),
            {std::string(kTimeLabel)}, {fmt::format("difference [{}]", triad.unit)});
  plot.size(kWidth, kHeight);
  for (int i = 0; i < 3; ++i) {
    const std::size_t axis = at(triad.first + i);
    const double factor = signal_info(triad.first + i).factor;
    const Curve c =
        curve(p.time, window, [&](std::size_t k) { return factor * (p.reference[axis][k] - p.measured[axis][k]); });
    const double mean = moments(c.y)[0];
    plot.line(c.x, c.y, i, std::string(kSignalNames[axis]));
    if (!c.x.empty()) plot.line({c.x.front(), c.x.back()}, {mean, mean}, i, "", Plot::Stroke::kDashed);
  }
  return {fmt::format("figure_{}_{}", after ? "10" : "09", triad.stem), plot.render(),
          fmt::format("What the bias at rest is the mean of, {}; dashed: the mean of what is drawn. {}", band_of(study),
                      kSign)};
}

// ---- Estimates, sensor by sensor ----

std::optional<Figure> estimates(const Study& study, const std::string& name, const std::string& title, Method method,
                                Quantity quantity, const Triad& triad) {
  const std::vector<AcrossRow> rows = study_text::of(triad, table_of(study, method, quantity));
  if (rows.empty()) return {};
  const bool bias = quantity == Quantity::kBias;
  Plot plot(title, {"axis", {}, false, axis_names(triad)},
            {bias ? fmt::format("bias [{}]", triad.unit) : std::string("scale' [ratio]")});
  plot.size(kWidth, kHeight);
  zero_line(plot, 3, Plot::Along::kY);
  Bars all;
  for (std::size_t s = 0; s < study.sensors.size(); ++s) {
    Bars bars;
    for (const AcrossRow& row : rows) {
      if (row.sensor != s) continue;
      const double x = row.axis - triad.first + beside(s, study.sensors.size());
      bars.add(x, row.value.mean, half_width(row.value));
      if (row.truth) all.add_truth(x, 0.06, *row.truth);
    }
    if (!bars.place.empty()) bars.draw(plot, static_cast<int>(s), study.sensors[s], Plot::Along::kY);
  }
  all.draw_truth(plot, Plot::Along::kY);
  return Figure{name, plot.render(),
                fmt::format("{} {}{}{}", info(method).how, bars_caption(rows), kSign, truth_caption(study))};
}

// ---- Methods beside each other ----

constexpr std::array kCompared{Method::kRest, Method::kJoint, Method::kBiasOnly, Method::kMarkovFiltered};

std::optional<Figure> comparison(const Study& study, const Triad& triad, int number) {
  std::vector<std::string> names;
  for (const std::string& sensor : study.sensors) {
    for (const std::string& axis : axis_names(triad)) names.push_back(fmt::format("{} {}", sensor, axis));
  }
  Plot plot(fmt::format("Figure {}. Biases of the {}: signals compared, and the filter", number, triad.name),
            {fmt::format("bias [{}]", triad.unit)}, {"sensor and axis", {}, false, names});
  plot.size(kWidth, static_cast<int>(44 * names.size()) + kFrame);
  zero_line(plot, names.size(), Plot::Along::kX);
  std::vector<AcrossRow> shown_rows;
  Bars all;
  for (std::size_t m = 0; m < kCompared.size(); ++m) {
    Bars bars;
    for (const AcrossRow& row : study_text::of(triad, table_of(study, kCompared[m], Quantity::kBias))) {
      const double y = static_cast<double>(3 * row.sensor) + row.axis - triad.first + beside(m, kCompared.size());
      bars.add(y, row.value.mean, half_width(row.value));
      if (row.truth) all.add_truth(y, 0.09, *row.truth);
      shown_rows.push_back(row);
    }
    if (!bars.place.empty()) {
      bars.draw(plot, static_cast<int>(m), std::string(info(kCompared[m]).title), Plot::Along::kX);
    }
  }
  if (shown_rows.empty()) return {};
  all.draw_truth(plot, Plot::Along::kX);
  return Figure{
      triad.first == 0 ? "figure_16" : "figure_17", plot.render(),
      fmt::format("{}{} “{}” and “{}” know no scale: theirs is bias + scale · mean signal.{}", bars_caption(shown_rows),
                  kSign, info(Method::kRest).title, info(Method::kBiasOnly).title, truth_caption(study))};
}

// ---- Methods against the truth ----

std::optional<Figure> against_truth(const std::vector<Comparison>& all, Quantity quantity, const Triad& triad) {
  std::vector<Comparison> rows;
  for (const Comparison& c : all) {
    if (c.b == Method::kTruth && triad.has(c.axis)) rows.push_back(c);
  }
  if (rows.empty()) return {};
  std::vector<Method> methods;
  std::size_t sensors = 0;
  for (const Comparison& c : rows) {
    if (methods.empty() || methods.back() != c.a) methods.push_back(c.a);
    sensors = std::max(sensors, c.sensor + 1);
  }
  std::vector<std::string> names;
  names.reserve(methods.size());
  for (const Method m : methods) names.emplace_back(info(m).title);
  const bool bias = quantity == Quantity::kBias;
  Plot plot(fmt::format("{} of the {} less the truth", bias ? "Bias" : "Scale'", triad.name),
            {bias ? fmt::format("bias less the truth [{}]", triad.unit) : std::string("scale' less the truth [ratio]")},
            {"method", {}, false, names});
  plot.size(kWidth, static_cast<int>(44 * names.size()) + kFrame);
  zero_line(plot, names.size(), Plot::Along::kX);
  const std::size_t places = 3 * sensors;
  for (int i = 0; i < 3; ++i) {
    Bars bars;
    for (const Comparison& c : rows) {
      if (c.axis != triad.first + i) continue;
      const auto row = std::find(methods.begin(), methods.end(), c.a) - methods.begin();
      bars.add(static_cast<double>(row) + beside(at(i) * sensors + c.sensor, places), c.difference.mean,
               half_width(c.difference));
    }
    bars.draw(plot, i, std::string(kSignalNames[at(triad.first + i)]), Plot::Along::kX);
  }
  return Figure{
      fmt::format("truth_{}_{}", bias ? "bias" : "scale", triad.stem), plot.render(),
      fmt::format("One bar for each sensor and axis: 95 % interval of the mean difference over the runs. Each "
                  "method is held to what it could see of the truth. {}",
                  kSign)};
}

// ---- Timing ----

std::optional<Figure> delays(const std::vector<TimingRow>& rows, const Triad& triad) {
  if (rows.empty()) return {};
  Plot plot(fmt::format("What a residual delay does to the scale of the {}", triad.name),
            {"delay of the reference [ms]"}, {"change of scale' [ratio]"});
  plot.size(kWidth, kHeight + 60);
  std::vector<double> delay;
  delay.reserve(rows.size());
  for (const TimingRow& row : rows) delay.push_back(kMilliseconds * row.delay);
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
    const double printed = study_text::article_scale(triad.first + i);
    plot.line({delay.front(), delay.back()}, {printed, printed}, i,
              fmt::format("{} in the article", kSignalNames[axis]), Plot::Stroke::kDotted);
  }
  return Figure{
      fmt::format("timing_{}", triad.stem), plot.render(),
      fmt::format("Mean over sensors and runs of scale' at that delay less scale' at none; bars: one standard "
                  "error between runs. Forward is the regression of the reference on the IMU, as in the "
                  "article; a delay drives the two directions apart. Dotted: mean over the sensors of the "
                  "article's Table 4. {}",
                  kSign)};
}

// ---- Ranking ----

std::vector<std::string> titles(const std::vector<RankingRow>& rows) {
  std::vector<std::string> out;
  out.reserve(rows.size());
  for (const RankingRow& row : rows) out.emplace_back(info(row.method).title);
  return out;
}

Figure scores(const std::vector<RankingRow>& rows, const Ranking& ranking) {
  Plot plot("Which estimate gives the best navigation?", {"score over the winner's [ratio]", {}, true},
            {"method", {}, false, titles(rows)});
  plot.size(kWidth, static_cast<int>(24 * rows.size()) + kFrame);
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
  const auto wins = [&](Method m) { return ranking.winner == m; };
  draw(2, "winner", wins);
  draw(0, "competes", [&](Method m) { return info(m).competes && !wins(m); });
  draw(kGrey, "for comparison", [](Method m) { return !info(m).competes; });
  return {
      "ranking", plot.render(),
      "Score: geometric mean of the errors of position, velocity and attitude and of the drift without GNSS, each "
      "over that of a replay that knows nothing. Bars: 95 % interval of the ratio to the winner, paired by run; one "
      "that reaches 1 is not told from the winner."};
}

std::optional<Figure> metrics(const std::vector<RankingRow>& rows) {
  const auto nothing =
      std::find_if(rows.begin(), rows.end(), [](const RankingRow& row) { return row.method == Method::kNothing; });
  if (nothing == rows.end()) return {};
  Plot plot("The four errors that make the score", {"error over that of knowing nothing [ratio]", {}, true},
            {"method", {}, false, titles(rows)});
  plot.size(kWidth, static_cast<int>(34 * rows.size()) + kFrame);
  constexpr std::array<std::pair<double RankingRow::*, const char*>, 4> kMetrics{
      {{&RankingRow::position_rmse, "position"},
       {&RankingRow::velocity_rmse, "velocity"},
       {&RankingRow::attitude_rmse, "attitude"},
       {&RankingRow::outage_drift, "drift without GNSS"}}};
  for (std::size_t m = 0; m < kMetrics.size(); ++m) {
    Bars dots;
    for (std::size_t i = 0; i < rows.size(); ++i) {
      const double ratio = rows[i].*kMetrics[m].first / *nothing.*kMetrics[m].first;
      dots.add(static_cast<double>(i) + beside(m, kMetrics.size()), ratio, kNaN);
    }
    dots.draw(plot, static_cast<int>(m), kMetrics[m].second, Plot::Along::kX);
  }
  return Figure{"ranking_metrics", plot.render(),
                "Root mean square over sensors and runs, over that of the replay that knows nothing; the numbers with "
                "their units stand in Table 7."};
}

void append(std::vector<Figure>& out, std::optional<Figure> figure) {
  if (figure) out.push_back(std::move(*figure));
}

}  // namespace

std::vector<Figure> study_signals(const Study& study) {
  const SensorRun* r = pictured(study);
  if (!r) return {};
  std::vector<Figure> out{whole_signal(study, *r, kTriads[0]), whole_signal(study, *r, kTriads[1])};
  const Phases& phases = study.runs[r->run].phases;
  for (const bool after : {false, true}) {
    if (!(after ? phases.after : phases.before)) continue;
    for (const Triad& triad : kTriads) out.push_back(at_rest(study, *r, triad, after));
  }
  return out;
}

std::vector<Figure> study_estimates(const Study& study) {
  const auto& [accel, gyro] = kTriads;
  std::vector<Figure> out;
  const auto add = [&](const char* name, const char* title, Method method, Quantity quantity, const Triad& triad) {
    append(out, estimates(study, name, title, method, quantity, triad));
  };
  add("figure_08_accel", "Figure 8. Biases of the accelerometers at rest before the start", Method::kRest,
      Quantity::kBias, accel);
  add("figure_08_gyro", "Figure 8. Biases of the gyroscopes at rest before the start", Method::kRest, Quantity::kBias,
      gyro);
  add("figure_13", "Figure 13. Biases of the accelerometers in the run", Method::kJoint, Quantity::kBias, accel);
  add("figure_14", "Figure 14. Biases of the gyroscopes in the run", Method::kJoint, Quantity::kBias, gyro);
  add("figure_15_accel", "Figure 15. Scales of the accelerometers in the run", Method::kJoint, Quantity::kScale, accel);
  add("figure_15_gyro", "Figure 15. Scales of the gyroscopes in the run", Method::kJoint, Quantity::kScale, gyro);
  return out;
}

std::vector<Figure> study_comparisons(const Study& study) {
  std::vector<Figure> out;
  append(out, comparison(study, kTriads[0], 16));
  append(out, comparison(study, kTriads[1], 17));
  return out;
}

std::vector<Figure> study_correlations(const Study& study) {
  const std::vector<CorrelationRow> rows = correlations(study);
  if (rows.empty()) return {};
  HeatMap map{.title = "Table 5. Correlation of bias and scale in the run",
              .description = "Formal correlation of bias and scale by sensor and axis",
              .rows = study.sensors,
              .columns = {kSignalNames.begin(), kSignalNames.end()},
              .values{study.sensors.size(), std::vector<double>(kSignals, kNaN)}};
  for (const CorrelationRow& row : rows) map.values[row.sensor][at(row.axis)] = row.correlation;
  return {
      {"table_5", map.render(),
       "Formal correlation of bias and scale in the regression of the IMU on the reference, mean magnitude over the "
       "runs: −mean / rms of the reference's signal. Near ±1 the motion does not tell the two apart."}};
}

std::vector<Figure> study_truth(const Study& study) {
  if (!study.simulated) return {};
  std::vector<Figure> out;
  for (const Quantity quantity : {Quantity::kBias, Quantity::kScale}) {
    const std::vector<Comparison> all = comparisons(study, quantity);
    for (const Triad& triad : kTriads) append(out, against_truth(all, quantity, triad));
  }
  return out;
}

std::vector<Figure> study_timing(const Study& study) {
  const std::vector<TimingRow> rows = timing(study);
  std::vector<Figure> out;
  for (const Triad& triad : kTriads) append(out, delays(rows, triad));
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
