#include "piste/recordings/allan.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>

#include "io/triad_units.h"
#include "math/parallel.h"
#include "math/words.h"
#include "piste/configuration/sensor_file.h"
#include "piste/core/error.h"
#include "piste/core/sensor_class.h"
#include "piste/inspect/inspection.h"
#include "recordings/allan_recording.h"

namespace piste {
namespace {

constexpr double kSameRate = 0.01;  // relative: IMUs whose rates differ by more are not of one type
constexpr double kDiffer = 0.01;    // p-value below which each axis gets its own value
constexpr double kCloseFit = 0.1;   // of the deviation: a model refused by chi-squared that is this close still serves
constexpr double kManyRounding = 0.25;  // share of the white noise's variance
constexpr int kSensorDigits = 3;

const TriadUnits& units_of(bool gyro) { return gyro ? kGyroUnits : kAccelUnits; }

std::string shown_value(double value, const TriadUnits& units) {
  return fmt::format("{:.3g} {}", value / unit_factor(units.value_unit, units.value), units.value_unit);
}

// The fit of a curve; nothing, with the reason, if there is none.
std::optional<GmwmFit> fitted(const AllanCurve& curve, const GmwmOptions& options, std::string& why_not) {
  try {
    return fit_gmwm(curve, options);
  } catch (const DataError& e) {
    why_not = e.what();
    return std::nullopt;
  }
}

std::vector<ProcessKind> kinds_of(const GmwmFit& fit) {
  std::vector<ProcessKind> kinds;
  for (const FittedProcess& p : fit.parts) kinds.push_back(p.process.kind);
  return kinds;
}

// The interval of the mean of IMUs that differ.
void widen(Measured& m, double spread, std::size_t units) {
  if (!(spread > 0) || !(m.sigma_log > 0)) return;
  const double sigma = std::hypot(m.sigma_log, spread / std::sqrt(static_cast<double>(units)));
  m.low = m.value * std::pow(m.low / m.value, sigma / m.sigma_log);
  m.high = m.value * std::pow(m.high / m.value, sigma / m.sigma_log);
  m.sigma_log = sigma;
}

void fit_axis(AllanAxis& axis, const AllanFindings& findings, std::size_t index) {
  GmwmOptions options = findings.options.fit;
  options.robust = findings.options.robust;
  std::vector<AllanCurve> curves;
  for (const AllanRecording& r : findings.recordings) {
    if (!r.curves[index].scales.empty()) curves.push_back(r.curves[index]);
    axis.step = std::max(axis.step, r.step[index]);
  }
  if (curves.empty()) {
    axis.why_not = "no stretch is long enough";
    return;
  }
  axis.curve = pooled(curves);
  axis.rounding = rounding_noise(axis.step, axis.curve.interval);
  axis.fit = fitted(axis.curve, options, axis.why_not);
  if (!axis.fit) return;
  axis.noise = axis_noise(*axis.fit, axis.curve, options.probability);
  if (curves.size() < 2) return;
  options.model = kinds_of(*axis.fit);
  std::vector<Measured> noises, instabilities;
  for (const AllanCurve& curve : curves) {
    AllanImu unit;
    std::string why_not;
    unit.fit = fitted(curve, options, why_not);
    if (unit.fit) {
      unit.noise = axis_noise(*unit.fit, curve, options.probability);
      noises.push_back(unit.noise.noise);
      instabilities.push_back(unit.noise.instability);
    }
    axis.imus.push_back(std::move(unit));
  }
  axis.spread = spread_between(noises);
  axis.spread_instability = spread_between(instabilities);
  widen(axis.noise.noise, axis.spread, noises.size());
  widen(axis.noise.instability, axis.spread_instability, instabilities.size());
}

// One triad of the sensor file, from the fitted axes.
void set_triad(TriadErrors& triad, AllanFindings& f, bool gyro) {
  const char* const name = gyro ? "gyro" : "accel";
  std::vector<Measured> noises;
  std::vector<AxisNoise> axes;
  double shortest = 0, longest = 0;
  Vector3d densities = Vector3d::Zero();
  for (std::size_t i = 0; i < 3; ++i) {
    const AllanAxis& axis = f.axes[i + (gyro ? 0 : 3)];
    if (!axis.fit || !(axis.noise.noise.value > 0)) continue;
    noises.push_back(axis.noise.noise);
    axes.push_back(axis.noise);
    densities(static_cast<Eigen::Index>(i)) = axis.noise.noise.value;
    shortest = axis.curve.tau(0);
    longest = axis.curve.tau(axis.fit->variance.size() - 1);
  }
  if (axes.empty()) {
    f.sensor_remarks.push_back(fmt::format(
        "{}.noise, .drift: no recording has them; {}", name,
        f.options.base ? "as in the sensor file that was given" : "a guess: state them before you use this file"));
    return;
  }
  const double p = equal_p_value(noises);
  if (axes.size() == 3 && p < kDiffer) {
    triad.set_densities(densities);
    f.sensor_remarks.push_back(
        fmt::format("{}.noise: one value an axis, as they differ by more than chance (p = {:.2g})", name, p));
  } else {
    triad.axes.setOnes();
    triad.noise = std::sqrt(densities.squaredNorm() / static_cast<double>(axes.size()));
    f.sensor_remarks.push_back(fmt::format(
        "{}.noise: one value, the mean square of {} {}", name, axes.size(),
        axes.size() == 1 ? "axis; the others were not recorded" : "axes, which do not differ by more than chance"));
  }
  const NearestDrift drift = nearest_drift(axes, shortest, longest);
  triad.drift = drift.process;
  std::string remark = fmt::format("{}.drift: {}", name, drift.why);
  if (drift.process.kind == DriftProcess::Kind::kNone) {
    remark += fmt::format(" in recordings of up to {}", time_text(longest));
  } else {
    remark += fmt::format(", mean of {} {}, over {} to {}", axes.size(), axes.size() == 1 ? "axis" : "axes",
                          time_text(std::max(shortest, kFastTime)), time_text(longest));
    if (drift.off > 0.05) remark += fmt::format("; its deviation is within {:.0f} % of the model's", 100 * drift.off);
    if (std::any_of(axes.begin(), axes.end(), [](const AxisNoise& a) { return a.flicker; }))
      remark += "; bias instability (flicker noise) has no state in a filter, so this process stands for it";
  }
  f.sensor_remarks.push_back(remark);
}

void make_sensor(AllanFindings& f, const ImuHealth& health) {
  f.sensor = f.options.base ? *f.options.base : guess_sensor(health, f.options.name);
  if (!f.options.base) f.sensor.name = f.options.name;
  set_triad(f.sensor.gyro, f, true);
  set_triad(f.sensor.accel, f, false);
  f.sensor_remarks.emplace_back(
      f.options.base
          ? fmt::format("bias, scale and range: not observable at rest; they are those of {}", f.options.base_file)
          : "bias, scale and range: not observable at rest; they are the usual ones of sensors with such noise. "
            "`--sensor FILE` takes them from a file");
  if (!f.options.base) {
    f.sensor_remarks.push_back(
        fmt::format("cross_axis and g_sensitivity: not observable at rest; they are the usual ones of a {} IMU",
                    class_of(f.sensor).name));
    f.sensor = with_errors_of_class(f.sensor);
  }
  f.sensor = rounded(f.sensor, kSensorDigits);
}

// What a recording of this length does not determine of one axis.
void add_undetermined(AllanFindings& f, const AllanAxis& axis) {
  const TriadUnits& units = units_of(axis.is_gyro);
  const std::string length = time_text(axis.curve.longest_stretch());
  for (const FittedProcess& p : axis.fit->parts) {
    if (p.determined) continue;
    f.undetermined.push_back(fmt::format("{}: {}: {} do not determine it within a factor of three{}", axis.name,
                                         name_of(p.process.kind), length,
                                         p.process.kind == ProcessKind::kGaussMarkov
                                             ? fmt::format(" (correlation time {:.3g} s, 95 % {:.3g} to {:.3g} s)",
                                                           p.process.correlation_time, p.low_time, p.high_time)
                                             : std::string()));
  }
  if (!axis.noise.flicker && !axis.noise.lowest_inside) {
    f.undetermined.push_back(
        fmt::format("{}: bias instability: the curve falls to its end at {:.3g} s, so {} is an upper "
                    "bound; a longer recording would determine it",
                    axis.name, axis.noise.instability_tau, shown_value(axis.noise.instability.value, units)));
  }
}

void add_warnings(AllanFindings& f, const AllanAxis& axis) {
  const GmwmFit& fit = *axis.fit;
  const TriadUnits& units = units_of(axis.is_gyro);
  if (!fit.fits()) {
    const bool close = fit.worst < kCloseFit;
    f.warnings.push_back(fmt::format(
        "{}: {}: no model describes the curve within its statistics (chi-squared {:.3g} of {:.0f}, p = {:.1g}); it is "
        "off by up to "
        "{:.2g} % of the deviation, at {:.3g} s. Intervals are widened by a model error of {:.2g} % of each deviation",
        axis.name, close ? "close fit" : "BAD FIT", fit.objective, fit.freedom, fit.p_value, 100 * fit.worst,
        fit.worst_tau, 50 * fit.model_error));
  }
  const double share = square(axis.rounding / axis.noise.noise.value);
  if (share > kManyRounding) {
    f.warnings.push_back(fmt::format("{}: rounding of the values to steps of {} makes {:.0f} % of the white noise",
                                     axis.name, shown_value(axis.step, units), 100 * share));
  }
  // Outliers raise the classical variance above the robust one at short scales.
  constexpr double kRaised = 1.1;
  const AllanScale& first = axis.curve.scales.front();
  if (!f.options.robust && std::sqrt(first.variance / first.robust) > kRaised) {
    f.warnings.push_back(
        fmt::format("{}: outliers raise the deviation by {:.0f} % above its robust estimate; `--robust` bounds what "
                    "they do",
                    axis.name, 100 * (std::sqrt(first.variance / first.robust) - 1)));
  }
}

void add_recording_warnings(AllanFindings& f, const AllanRecording& r) {
  const std::string& file = r.source.log.file;
  for (const std::string& doubt : r.source.doubts) f.warnings.push_back(fmt::format("{}: {}", file, doubt));
  if (r.refused > 0)
    f.warnings.push_back(fmt::format("{}: {} rows cannot be read; the first: {}", file, r.refused, r.first_refused));
  if (r.moving > 1) {
    f.warnings.push_back(fmt::format("{}: {} of {} are left out, as the IMU moves or the rest is shorter than {}", file,
                                     time_text(r.moving), time_text(r.span), time_text(f.options.shortest_rest)));
  }
  if (r.disturbances > 0) {
    f.warnings.push_back(fmt::format("{}: {} disturbances shorter than {} remain{}", file, r.disturbances,
                                     time_text(f.options.longest_disturbance),
                                     f.options.robust ? "" : "; `--robust` bounds what they do"));
  }
  if (!r.rest_checked && !f.options.at_rest)
    f.warnings.push_back(fmt::format("{}: rows come too rarely to detect whether the IMU rests", file));
  if (r.gaps > 0) {
    constexpr double kManyFilled = 0.01;  // of all rows: as many change the white noise by more than its interval
    const double share = static_cast<double>(r.filled) / static_cast<double>(r.rows + r.filled);
    f.warnings.push_back(
        fmt::format("{}: {} gaps with {} missing rows: {} were bridged by straight lines, the others part "
                    "{} stretches, which are averaged by their lengths{}",
                    file, r.gaps, r.missing, r.filled, r.stretches.size(),
                    share < kManyFilled
                        ? ""
                        : fmt::format(". {:.0f} % of the rows are such lines, which have no noise of their own: the "
                                      "intervals do not hold; take a log without gaps, of one rate",
                                      100 * share)));
  }
  constexpr double kSteady = 2;  // °C
  if (r.temperature && (*r.temperature)[1] - (*r.temperature)[0] > kSteady) {
    f.warnings.push_back(
        fmt::format("{}: the temperature is {:.1f} to {:.1f} °C; what it does to the biases looks like a ramp or a "
                    "random walk, and stands in `drift`. Leave out the warm-up, or take a log of an even temperature",
                    file, (*r.temperature)[0], (*r.temperature)[1]));
  }
  constexpr double kJitter = 0.2;
  if (r.jitter > kJitter * r.interval) {
    f.warnings.push_back(
        fmt::format("{}: time stamps scatter by {} about an interval of {}; samples are taken to be even", file,
                    time_text(r.jitter), time_text(r.interval)));
  }
  std::size_t outliers = 0;
  for (const std::size_t n : r.outliers) outliers += n;
  if (outliers > 0) {
    f.warnings.push_back(
        fmt::format("{}: {} values are beyond six sigmas{}", file, outliers,
                    f.options.robust ? " and were replaced by the median around them" : "; `--robust` replaces them"));
  }
}

void check_rates(const std::vector<AllanRecording>& recordings) {
  for (const AllanRecording& r : recordings) {
    const AllanRecording& first = recordings.front();
    if (std::abs(r.interval / first.interval - 1) <= kSameRate) continue;
    throw DataError(r.source.log.file,
                    fmt::format("comes at {:.4g} Hz, and {} at {:.4g} Hz; recordings of one type of IMU have "
                                "one rate: run allan on each rate by itself",
                                1 / r.interval, first.source.log.file, 1 / first.interval));
  }
}

}  // namespace

AllanFindings find_noise(const AllanRequest& request, const ProgressCallback& progress) {
  constexpr double kRead = 0.7;  // part of the work
  AllanFindings f;
  f.options = request.options;
  std::optional<ImuHealth> health;
  for (const AllanSource& source : request.sources) {
    ReadRecording read = read_at_rest(source, f.options);
    if (!health) health = std::move(read.health);
    f.recordings.push_back(std::move(read.found));
    if (progress)
      progress(kRead * static_cast<double>(f.recordings.size()) / static_cast<double>(request.sources.size()));
  }
  check_rates(f.recordings);
  for (std::size_t i = 0; i < f.axes.size(); ++i) {
    f.axes[i].name = kAllanAxes[i];
    f.axes[i].is_gyro = i < 3;
  }
  for_each_parallel(f.axes.size(), f.options.jobs, [&](std::size_t i) { fit_axis(f.axes[i], f, i); });
  if (std::none_of(f.axes.begin(), f.axes.end(), [](const AllanAxis& a) { return a.fit.has_value(); })) {
    throw DataError(f.recordings.front().source.log.file,
                    fmt::format("no axis can be fitted: {}", f.axes.front().why_not));
  }
  for (const AllanRecording& r : f.recordings) add_recording_warnings(f, r);
  for (const AllanAxis& axis : f.axes) {
    if (!axis.fit) {
      f.warnings.push_back(fmt::format("{}: not fitted: {}", axis.name, axis.why_not));
      continue;
    }
    add_warnings(f, axis);
    add_undetermined(f, axis);
  }
  constexpr double kLongestPart = 0.2;
  double longest = 0;
  for (const AllanRecording& r : f.recordings) {
    for (const Interval& s : r.stretches) longest = std::max(longest, s.end - s.start);
  }
  f.undetermined.push_back(
      fmt::format("drifts with a correlation time beyond {}, a fifth of the longest stretch, cannot be distinguished "
                  "from a random walk or a ramp",
                  time_text(kLongestPart * longest)));
  make_sensor(f, *health);
  return f;
}

}  // namespace piste
