#include "piste/report/allan_page.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>
#include <vector>

#include "math/words.h"
#include "piste/math/statistics.h"
#include "piste/report/allan_text.h"
#include "plot/markup.h"
#include "plot/svg.h"
#include "plot/svg_frame.h"
#include "report/drawing.h"
#include "report/page.h"

namespace piste {
namespace {

enum CurveColour { kCurveColour, kModelColour = svg::kInk };

// One colour a kind of process, on every axis.
int colour_of(ProcessKind kind) { return 1 + static_cast<int>(kind) % 6; }
constexpr int kCurveHeight = 380;  // px

constexpr std::string_view kHowToReadAllan =
    R"(<p>The <strong>Allan deviation</strong> at τ says by how much the means of two neighbouring stretches of length τ differ. White
noise falls with √τ; where the curve is flat, averaging longer does not help; where it rises, the bias drifts.</p>
<p>The <strong>model</strong> is a sum of noise processes, fitted to all scales at once with the covariance that the model itself
implies between them (generalised method of wavelet moments). Of all models the one is taken whose misfit and penalty are least
together; each number of a model costs the same penalty.</p>
<p>The <strong>white noise that a filter meets</strong> holds all that is correlated over less than a second. A <strong>bias
instability</strong> that is no flicker noise of the model is the lowest deviation over 0.664, as data sheets state it.</p>
<p>Intervals and bands are of the probability above. "Not determined" means that the curve does not determine the number within a
factor of three.</p>
)";

/// The slope of a process' deviation over the averaging time, both logarithmic, with its name.
std::string with_slope(ProcessKind kind) {
  switch (kind) {
    case ProcessKind::kQuantisation:
      return fmt::format("{}, slope −1", name_of(kind));
    case ProcessKind::kWhite:
      return fmt::format("{}, slope −½", name_of(kind));
    case ProcessKind::kBiasInstability:
      return fmt::format("{}, slope 0", name_of(kind));
    case ProcessKind::kRandomWalk:
      return fmt::format("{}, slope ½", name_of(kind));
    case ProcessKind::kRamp:
      return fmt::format("{}, slope 1", name_of(kind));
    case ProcessKind::kGaussMarkov:
      break;
  }
  return std::string(name_of(kind));
}

std::string axis_title(const AllanAxis& axis) {
  return fmt::format("{} {}", axis.is_gyro ? "Gyroscope" : "Accelerometer", axis.name.back());
}

Figure picture(const AllanAxis& axis) {
  const AllanCurve& curve = axis.curve;
  const double unit = unit_of(ProcessKind::kBiasInstability, axis.is_gyro).factor;
  std::vector<double> tau, deviation, low, high, model;
  for (std::size_t i = 0; i < curve.scales.size(); ++i) {
    tau.push_back(curve.tau(i));
    deviation.push_back(std::sqrt(curve.scales[i].variance) / unit);
  }
  Plot plot(axis_title(axis), {.label = "τ [s]", .log = true},
            {.label = fmt::format("Allan deviation [{}]", unit_of(ProcessKind::kBiasInstability, axis.is_gyro).name),
             .log = true},
            fmt::format("Allan deviation of {} over averaging time, with its band and the fitted model", axis.name));
  plot.size(Plot::kPageWidth, kCurveHeight);
  const auto& v = axis.fit->variance;
  const std::vector<double> covered(tau.begin(), tau.begin() + static_cast<std::ptrdiff_t>(v.size()));
  for (std::size_t i = 0; i < tau.size(); ++i) {
    const bool is_covered = i < v.size();
    low.push_back(is_covered ? std::sqrt(axis.fit->low[i]) / unit : kNaN);
    high.push_back(is_covered ? std::sqrt(axis.fit->high[i]) / unit : kNaN);
    if (is_covered) model.push_back(std::sqrt(v[i]) / unit);
  }
  const auto [least, most] = std::minmax_element(deviation.begin(), deviation.end());
  constexpr double kRoom = 2;
  plot.limit_y(*least / kRoom, *most * kRoom);
  const auto& parts = axis.fit->parts;
  for (std::size_t k = 0; k < parts.size() && parts.size() > 1; ++k) {
    const FittedProcess& p = parts[k];
    std::vector<double> part;
    part.reserve(v.size());
    for (std::size_t i = 0; i < v.size(); ++i) {
      part.push_back(std::sqrt(allan_variance(p.process, curve.scales[i].samples, curve.interval)) / unit);
    }
    plot.line(covered, part, colour_of(p.process.kind), with_slope(p.process.kind), Plot::Stroke::kDotted);
  }
  plot.line(covered, model, kModelColour, "model");
  plot.bars(tau, deviation, low, high, kCurveColour, "measured");
  return as_figure(axis.name, std::move(plot),
                   fmt::format("Allan deviation of {}: measured, with the interval of each point, and the fitted "
                               "model with its parts. A slope is that of both logarithms.",
                               axis.name));
}

std::string numbers_table(const AllanFindings& f) {
  std::vector<page::Row> rows;
  for (const AllanAxis& axis : f.axes) {
    if (!axis.fit) continue;
    const ProcessUnit noise = unit_of(ProcessKind::kWhite, axis.is_gyro),
                      value = unit_of(ProcessKind::kBiasInstability, axis.is_gyro);
    rows.push_back({axis.name, interval_text(axis.noise.noise, noise.factor, noise.name),
                    interval_text(axis.noise.instability, value.factor, value.name),
                    axis.noise.flicker ? "flicker noise"
                    : axis.noise.lowest_inside
                        ? fmt::format("lowest deviation, at {:.3g} s", axis.noise.instability_tau)
                        : "an upper bound",
                    axis.fit->name()});
  }
  return page::wide(
      page::table("", {"axis", "white noise that a filter meets", "bias instability", "which is", "model"}, rows));
}

std::string processes_table(const AllanFindings& f) {
  std::vector<page::Row> rows;
  for (const AllanAxis& axis : f.axes) {
    if (!axis.fit) continue;
    for (const FittedProcess& p : axis.fit->parts) {
      const ProcessUnit unit = unit_of(p.process.kind, axis.is_gyro);
      const bool timed = p.process.kind == ProcessKind::kGaussMarkov;
      rows.push_back({axis.name, std::string(name_of(p.process.kind)),
                      interval_text({p.process.size, p.low, p.high}, unit.factor, unit.name),
                      timed ? interval_text({p.process.correlation_time, p.low_time, p.high_time}, 1, "s") : "",
                      p.determined ? "yes" : "no"});
    }
    for (const UnseenProcess& u : axis.fit->unseen) {
      const ProcessUnit unit = unit_of(u.kind, axis.is_gyro);
      rows.push_back({axis.name, std::string(name_of(u.kind)),
                      fmt::format("below {:.3g} {}", u.below / unit.factor, unit.name), "", "not seen"});
    }
  }
  return page::wide(page::table("", {"axis", "process", "size", "correlation time", "determined"}, rows));
}

std::string models_table(const AllanFindings& f) {
  constexpr std::size_t kShown = 3;
  std::vector<page::Row> rows;
  for (const AllanAxis& axis : f.axes) {
    if (!axis.fit) continue;
    for (std::size_t i = 0; i < std::min(kShown, axis.fit->tried.size()); ++i) {
      const TriedModel& m = axis.fit->tried[i];
      rows.push_back({i == 0 ? axis.name : "", m.name, fmt::format("{:.2f}", m.objective),
                      fmt::format("{:.0f}", m.penalty), fmt::format("{:.2f}", m.criterion())});
    }
  }
  return page::wide(page::table("", {"axis", "model", "misfit", "penalty", "sum"}, rows));
}

std::string units_table(const AllanFindings& f) {
  if (f.recordings.size() < 2) return {};
  std::vector<page::Row> rows;
  for (const AllanAxis& axis : f.axes) {
    const ProcessUnit noise = unit_of(ProcessKind::kWhite, axis.is_gyro),
                      value = unit_of(ProcessKind::kBiasInstability, axis.is_gyro);
    for (std::size_t i = 0; i < axis.imus.size(); ++i) {
      const AllanImu& u = axis.imus[i];
      rows.push_back({i == 0 ? axis.name : "", f.recordings[i].source.log.file,
                      u.fit ? interval_text(u.noise.noise, noise.factor, noise.name) : "not fitted",
                      u.fit ? interval_text(u.noise.instability, value.factor, value.name) : ""});
    }
    if (axis.imus.size() > 1) {
      rows.push_back({"", "spread between units beyond chance", fmt::format("{:.1f} %", 100 * axis.spread),
                      fmt::format("{:.1f} %", 100 * axis.spread_instability)});
    }
  }
  return page::wide(page::table("", {"axis", "unit", "white noise that a filter meets", "bias instability"}, rows));
}

std::string recordings_table(const AllanFindings& f) {
  std::vector<page::Row> rows;
  for (const AllanRecording& r : f.recordings) {
    std::size_t outliers = 0;
    for (const std::size_t n : r.outliers) outliers += n;
    rows.push_back({r.source.log.file, fmt::format("{}", r.rows), fmt::format("{:.5g} Hz", 1 / r.interval),
                    time_text(r.used()), time_text(r.moving), fmt::format("{} ({} rows)", r.gaps, r.missing),
                    fmt::format("{}", outliers)});
  }
  return page::wide(
      page::table("", {"recording", "rows", "rate", "used", "left out", "gaps", "values beyond six sigmas"}, rows));
}

}  // namespace

std::string allan_page(const AllanFindings& f, const std::string& sensor_file, const std::string& version) {
  page::Drawing drawing;
  std::vector<Figure> curves;
  for (const AllanAxis& axis : f.axes) {
    if (axis.fit) curves.push_back(picture(axis));
  }
  std::vector<page::Section> sections{
      {"numbers", "What a data sheet would say", numbers_table(f) + page::list("Warnings", f.warnings)},
      {"curves", "Curves", drawing.add(curves)},
      {"processes", "Processes",
       processes_table(f) + page::list("What recordings of this length do not determine", f.undetermined)},
      {"models", "Models that were tried", models_table(f)}};
  if (f.recordings.size() > 1) sections.push_back({"units", "Unit by unit", units_table(f)});
  sections.push_back({"recordings", "Recordings", recordings_table(f)});
  sections.push_back(
      {"sensor", "Sensor file",
       fmt::format("<pre>{}</pre>\n", escape_markup(sensor_file)) + page::list("How it came about", f.sensor_remarks)});
  sections.push_back({"reading", "How to read it", std::string(kHowToReadAllan)});
  return page::render({.title = f.options.name,
                       .subtitle = fmt::format("piste {} · noise of an IMU at rest · bands and intervals of {:g} %",
                                               escape_markup(version), 100 * f.options.fit.probability),
                       .head = drawing.head(),
                       .sections = sections,
                       .style = drawing.style(),
                       .scripts = drawing.scripts()});
}

}  // namespace piste
