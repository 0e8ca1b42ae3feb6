// Figures 8 and 13 to 17, Table 5 as colours, and estimates minus the truth.

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <optional>
#include <vector>

#include "piste/math/statistics.h"
#include "piste/report/study_figures.h"
#include "piste/study/study_tables.h"
#include "plot/heat_map.h"
#include "plot/svg.h"
#include "report/study_bars.h"
#include "report/study_words.h"

namespace piste {
namespace {

using study_bars::append;
using study_bars::axis_names;
using study_bars::bar_offset;
using study_bars::Bars;
using study_bars::bars_caption;
using study_bars::kFrame;
using study_bars::kHeight;
using study_bars::kSign;
using study_bars::truth_caption;
using study_bars::zero_line;
using study_words::at;
using study_words::half_width;
using study_words::kTriads;
using study_words::Triad;

std::optional<Figure> estimates(const Study& study, const std::string& name, const std::string& title, Method method,
                                StudyQuantity quantity, const Triad& triad) {
  const std::vector<AcrossRow> rows = study_words::of(triad, table_of(study, method, quantity));
  if (rows.empty()) return {};
  const bool bias = quantity == StudyQuantity::kBias;
  Plot plot(title, {"axis", {}, false, axis_names(triad)},
            {bias ? fmt::format("bias [{}]", triad.unit) : std::string("scale' [ratio]")});
  plot.size(Plot::kPageWidth, kHeight);
  zero_line(plot, 3, Plot::Along::kY);
  Bars all;
  for (std::size_t s = 0; s < study.sensors.size(); ++s) {
    Bars bars;
    for (const AcrossRow& row : rows) {
      if (row.sensor != s) continue;
      const double x = row.axis - triad.first + bar_offset(s, study.sensors.size());
      bars.add(x, row.value.mean, half_width(row.value));
      if (row.truth) all.add_truth(x, 0.06, *row.truth);
    }
    if (!bars.place.empty()) bars.draw(plot, static_cast<int>(s), study.sensors[s], Plot::Along::kY);
  }
  all.draw_truth(plot, Plot::Along::kY);
  return Figure{name, plot.render(),
                fmt::format("{} {}{}{}", info(method).how, bars_caption(rows), kSign, truth_caption(study))};
}

// ---- Methods compared ----

constexpr std::array kCompared{Method::kRest, Method::kJoint, Method::kBiasOnly, Method::kMarkovFiltered};

std::optional<Figure> comparison(const Study& study, const Triad& triad) {
  std::vector<std::string> names;
  for (const std::string& sensor : study.sensors) {
    for (const std::string& axis : axis_names(triad)) names.push_back(fmt::format("{} {}", sensor, axis));
  }
  Plot plot(fmt::format("Biases of the {}: signals compared, and the filter", triad.name),
            {fmt::format("bias [{}]", triad.unit)}, {"sensor and axis", {}, false, names});
  plot.size(Plot::kPageWidth, static_cast<int>(44 * names.size()) + kFrame);
  zero_line(plot, names.size(), Plot::Along::kX);
  std::vector<AcrossRow> shown_rows;
  Bars all;
  for (std::size_t m = 0; m < kCompared.size(); ++m) {
    Bars bars;
    for (const AcrossRow& row : study_words::of(triad, table_of(study, kCompared[m], StudyQuantity::kBias))) {
      const double y = static_cast<double>(3 * row.sensor) + row.axis - triad.first + bar_offset(m, kCompared.size());
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

std::optional<Figure> against_truth(const std::vector<Comparison>& all, StudyQuantity quantity, const Triad& triad) {
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
  const bool bias = quantity == StudyQuantity::kBias;
  Plot plot(fmt::format("{} of the {} less the truth", bias ? "Bias" : "Scale'", triad.name),
            {bias ? fmt::format("bias less the truth [{}]", triad.unit) : std::string("scale' less the truth [ratio]")},
            {"method", {}, false, names});
  plot.size(Plot::kPageWidth, static_cast<int>(44 * names.size()) + kFrame);
  zero_line(plot, names.size(), Plot::Along::kX);
  const std::size_t places = 3 * sensors;
  for (int i = 0; i < 3; ++i) {
    Bars bars;
    for (const Comparison& c : rows) {
      if (c.axis != triad.first + i) continue;
      const auto row = std::find(methods.begin(), methods.end(), c.a) - methods.begin();
      bars.add(static_cast<double>(row) + bar_offset(at(i) * sensors + c.sensor, places), c.difference.mean,
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

}  // namespace

std::vector<Figure> study_estimates(const Study& study) {
  const auto& [accel, gyro] = kTriads;
  std::vector<Figure> out;
  const auto add = [&](const char* name, const char* title, Method method, StudyQuantity quantity, const Triad& triad) {
    append(out, estimates(study, name, title, method, quantity, triad));
  };
  add("figure_08_accel", "Biases of the accelerometers at rest before the start", Method::kRest, StudyQuantity::kBias,
      accel);
  add("figure_08_gyro", "Biases of the gyroscopes at rest before the start", Method::kRest, StudyQuantity::kBias, gyro);
  add("figure_13", "Biases of the accelerometers in the run", Method::kJoint, StudyQuantity::kBias, accel);
  add("figure_14", "Biases of the gyroscopes in the run", Method::kJoint, StudyQuantity::kBias, gyro);
  add("figure_15_accel", "Scales of the accelerometers in the run", Method::kJoint, StudyQuantity::kScale, accel);
  add("figure_15_gyro", "Scales of the gyroscopes in the run", Method::kJoint, StudyQuantity::kScale, gyro);
  return out;
}

std::vector<Figure> study_comparisons(const Study& study) {
  std::vector<Figure> out;
  append(out, comparison(study, kTriads[0]));
  append(out, comparison(study, kTriads[1]));
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
       "runs: −mean / rms of the reference's signal. Near ±1 the motion does not separate the two."}};
}

std::vector<Figure> study_truth(const Study& study) {
  if (!study.simulated) return {};
  std::vector<Figure> out;
  for (const StudyQuantity quantity : {StudyQuantity::kBias, StudyQuantity::kScale}) {
    const std::vector<Comparison> all = comparisons(study, quantity);
    for (const Triad& triad : kTriads) append(out, against_truth(all, quantity, triad));
  }
  return out;
}

}  // namespace piste
