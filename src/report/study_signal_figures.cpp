// Figures 7, 9 and 10: the signals of one IMU and of the reference.

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <optional>
#include <string_view>
#include <utility>
#include <vector>

#include "piste/report/study_figures.h"
#include "plot/svg.h"
#include "plot/svg_frame.h"
#include "report/study_bars.h"
#include "report/study_words.h"

namespace piste {
namespace {

using study_bars::kHeight;
using study_bars::kSign;
using study_words::at;
using study_words::band_of;
using study_words::kTriads;
using study_words::Triad;

const SensorRun* pictured(const Study& study) {
  for (const SensorRun& r : study.results) {
    if (r.picture && !r.picture->time.empty()) return &r;
  }
  return nullptr;
}

struct SignalCurve {
  std::vector<double> x, y;
};

/// `values` over `time` since its beginning, inside `window`.
template <class Value>
SignalCurve curve(const std::vector<double>& time, const std::optional<Interval>& window, const Value& value) {
  SignalCurve out;
  for (std::size_t i = 0; i < time.size(); ++i) {
    if (window && !window->contains(time[i])) continue;
    out.x.push_back(time[i] - time.front());
    out.y.push_back(value(i));
  }
  return out;
}

/// Mean and standard deviation of the finite values.
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

/// The axis of a triad with the most motion.
int liveliest(const SignalPicture& picture, const Triad& triad) {
  const auto spread = [&](int axis) { return moments(picture.reference[at(axis)])[1]; };
  int best = triad.first;
  for (int axis = triad.first + 1; axis < triad.first + 3; ++axis) {
    if (spread(axis) > spread(best)) best = axis;
  }
  return best;
}

constexpr std::string_view kRunTimeLabel = "GPS time after the first sample [s]";

std::string who(const Study& study, const SensorRun& r) {
  return fmt::format("{}, {}", study.sensors[r.sensor], study.runs[r.run].name);
}

Figure whole_signal(const Study& study, const SensorRun& r, const Triad& triad) {
  const SignalPicture& p = *r.picture;
  const int axis = liveliest(p, triad);
  const double factor = signal_info(axis).factor;
  Plot plot(fmt::format("{} of {}: rest, run and rest", kSignalNames[at(axis)], who(study, r)),
            {std::string(kRunTimeLabel)}, {fmt::format("{} [{}]", kSignalNames[at(axis)], triad.unit)});
  plot.size(Plot::kPageWidth, kHeight);
  const Phases& phases = study.runs[r.run].phases;
  const auto shade = [&](const std::optional<Interval>& phase, int colour, const char* label) {
    if (phase) plot.shade(phase->start - p.time.front(), phase->end - p.time.front(), colour, label);
  };
  shade(phases.before, 2, "rest before");
  shade(phases.run, 4, "run");
  shade(phases.after, 3, "rest after");
  const auto draw = [&](const std::vector<double>& series, int colour, const char* label, Plot::Stroke stroke) {
    const SignalCurve c = curve(p.time, {}, [&](std::size_t i) { return factor * series[i]; });
    plot.line(c.x, c.y, colour, label, stroke);
  };
  draw(p.measured[at(axis)], 0, "IMU", Plot::Stroke::kSolid);
  draw(p.reference[at(axis)], 1, "reference, turned and moved", Plot::Stroke::kSolid);
  return as_figure(
      fmt::format("figure_07_{}", triad.stem), std::move(plot),
      fmt::format(
          "The axis of the {} that the motion drives most, {}, compared with the reference; the three phases are "
          "shaded.",
          triad.name, band_of(study)));
}

Figure at_rest(const Study& study, const SensorRun& r, const Triad& triad, bool after) {
  const SignalPicture& p = *r.picture;
  const Phases& phases = study.runs[r.run].phases;
  const auto& window = after ? phases.after : phases.before;
  Plot plot(fmt::format("At rest {} the {}: reference less IMU, {}", after ? "after" : "before",
                        after ? "stop" : "start", who(study, r)),
            {std::string(kRunTimeLabel)}, {fmt::format("difference [{}]", triad.unit)});
  plot.size(Plot::kPageWidth, kHeight);
  std::vector<SignalCurve> means;
  for (int i = 0; i < 3; ++i) {
    const std::size_t axis = at(triad.first + i);
    const double factor = signal_info(triad.first + i).factor;
    const SignalCurve c =
        curve(p.time, window, [&](std::size_t k) { return factor * (p.reference[axis][k] - p.measured[axis][k]); });
    plot.line(c.x, c.y, i, std::string(kSignalNames[axis]));
    if (c.x.empty()) continue;
    const double mean = moments(c.y)[0];
    means.push_back({{c.x.front(), c.x.back()}, {mean, mean}});
  }
  // Drawn above the curves, in a colour that none of them has.
  for (const SignalCurve& mean : means) {
    plot.line(mean.x, mean.y, svg::kInk, &mean == means.data() ? "mean" : "", Plot::Stroke::kDashed);
  }
  return as_figure(
      fmt::format("figure_{}_{}", after ? "10" : "09", triad.stem), std::move(plot),
      fmt::format("What the bias at rest is the mean of, {}; dashed: the mean. {}", band_of(study), kSign));
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

}  // namespace piste
