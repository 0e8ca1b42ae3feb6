#include "piste/report/alignment_figures.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <limits>
#include <optional>
#include <span>
#include <string_view>

#include "fit/spectrum.h"
#include "piste/condition/aligned_signals.h"
#include "piste/math/statistics.h"
#include "piste/math/units.h"
#include "plot/svg.h"

namespace piste {
namespace {

constexpr int kSignalHeight = 320;  // px
constexpr double kLively = 4;       // s of the fastest motion
constexpr double kAroundPeak = 2;   // s on each side
constexpr double kSegment = 10;     // s of a periodogram
constexpr double kInformative = 5;  // times the smallest sigma: the axis shows offsets up to this sigma
constexpr const char* kTimeLabel = "GPS time after the body IMU's first sample [s]";
enum SignalColour { kBodyColour, kReferenceColour, kLeftColour, kKnownColour, kAlignmentColour = 6 };

// One triad of both IMUs, in the unit that pictures show.
struct Quantity {
  std::string_view name, stem, unit;
  double factor;
  std::vector<Vector3d> AlignedImus::*body;
  std::vector<Vector3d> AlignedImus::*reference;
  int bias, scale;  // in the covariance's order
};

constexpr std::array<Quantity, 2> kQuantities{
    {{"angular rate", "rate", "deg/s", kDegreesPerRadian, &AlignedImus::gyro, &AlignedImus::reference_gyro,
      AlignmentLayout::kGyroBias, AlignmentLayout::kGyroScale},
     {"specific force", "force", "m/s²", 1, &AlignedImus::accel, &AlignedImus::reference_accel,
      AlignmentLayout::kAccelBias, AlignmentLayout::kAccelScale}}};
constexpr std::array<std::string_view, 3> kAxes{"x", "y", "z"};

bool is_rate(const Quantity& q) { return q.bias == AlignmentLayout::kGyroBias; }

// measured − (1 + scale) reference − bias, with the estimated scales and biases.
std::vector<Vector3d> left_over(const Quantity& q, const AlignedImus& imus, const Alignment& alignment) {
  const Vector3d bias = alignment.known(is_rate(q) ? alignment.gyro_bias : alignment.accel_bias, q.bias);
  const Vector3d scale = alignment.known(is_rate(q) ? alignment.gyro_scale : alignment.accel_scale, q.scale);
  std::vector<Vector3d> out;
  out.reserve(imus.time.size());
  for (std::size_t i = 0; i < imus.time.size(); ++i) {
    const Vector3d& x = (imus.*q.reference)[i];
    out.emplace_back((imus.*q.body)[i] - x - scale.cwiseProduct(x) - bias);
  }
  return out;
}

// Usable samples [first, last) of the seconds in which the reference turns most.
std::optional<Stretch> liveliest(const AlignedImus& imus) {
  const auto wanted = static_cast<std::size_t>(kLively / imus.interval);
  std::optional<Stretch> best;
  double most = -1;
  for (const Stretch& s : usable_stretches(imus)) {
    const std::size_t length = std::min(wanted, s.size());
    if (length < wanted && best) continue;
    double sum = 0;
    for (std::size_t i = s.first; i < s.last; ++i) {
      sum += imus.reference_gyro[i].squaredNorm();
      if (i >= s.first + length) sum -= imus.reference_gyro[i - length].squaredNorm();
      if (i + 1 < s.first + length || sum <= most) continue;
      most = sum;
      best = Stretch{i + 1 - length, i + 1};
    }
  }
  return best;
}

struct Curve {
  std::vector<double> x, y;
};

// Norm of the rate against `time(sample)`, of the samples whose time lies in `window`.
template <class Time>
Curve norms(const std::vector<ImuSample>& samples, const Interval& window, const Time& time) {
  Curve out;
  for (const ImuSample& s : samples) {
    const double t = time(s);
    if (!window.contains(t)) continue;
    out.x.push_back(t);
    out.y.push_back(s.gap ? kNaN : kDegreesPerRadian * s.dtheta.norm() / s.interval);
  }
  return out;
}

std::string norm_label() { return "|rate| [deg/s]"; }

// Both clocks unchanged, from a common zero at the body IMU's first sample. If the logs do not overlap, each has its
// own zero.
struct RawClocks {
  double body_zero, reference_zero;
  bool common;
  std::string label() const {
    return common ? "reading of either clock, after the body IMU's first sample [s]"
                  : "reading of either clock, after its own first sample [s]";
  }
};

RawClocks raw_clocks(const AlignmentPicture& p) {
  const double body = p.body->front().time, reference = p.reference->front().time;
  const bool common = reference < p.body->back().time && body < p.reference->back().time;
  return {body, common ? body : reference, common};
}

// Some seconds of both norms, body IMU over reference.
Plot two_norms(const std::string& title, const std::string& x_label, const Curve& body, const Curve& reference) {
  Plot plot(title, {x_label}, {norm_label()});
  plot.size(Plot::kPageWidth, kSignalHeight);
  plot.line(reference.x, reference.y, kReferenceColour, "reference");
  plot.line(body.x, body.y, kBodyColour, "body IMU");
  return plot;
}

// A vertical line.
void upright(Plot& plot, double x, double low, double high, std::string label) {
  plot.line({x, x}, {low, high}, kAlignmentColour, std::move(label), Plot::Stroke::kDotted);
}

}  // namespace

std::vector<Figure> clock_figures(const AlignmentPicture& p) {
  const RawClocks raw = raw_clocks(p);
  const auto body_time = [&](const ImuSample& s) { return s.time - raw.body_zero; };
  const auto reference_time = [&](const ImuSample& s) { return s.time - raw.reference_zero; };
  const Interval whole{std::min(body_time(p.body->front()), reference_time(p.reference->front())),
                       std::max(body_time(p.body->back()), reference_time(p.reference->back()))};
  std::vector<Figure> out;
  for (const bool body : {true, false}) {
    const std::string who = body ? "body IMU" : "reference";
    const Curve curve = body ? norms(*p.body, whole, body_time) : norms(*p.reference, whole, reference_time);
    Plot plot(fmt::format("Before: {}", who), {raw.label()}, {norm_label()},
              fmt::format("Norm of the angular rate of the {} on its own clock", who));
    plot.size(Plot::kPageWidth, kSignalHeight - 60);
    plot.limit_x(whole.start, whole.end);
    plot.line(curve.x, curve.y, body ? kBodyColour : kReferenceColour, "");
    out.push_back(as_figure(body ? "before_body" : "before_reference", plot,
                            fmt::format("Norm of the angular rate of the {}, as it came, on its own clock.", who)));
  }

  const auto lively = liveliest(*p.aligned);
  if (!lively) return out;
  // The same seconds on the clock of the body IMU and on that of the reference.
  const double first = p.body->front().time;
  const auto aligned_time = [&](const ImuSample& s) { return p.alignment->reference_time(s.time, first); };
  const double origin = p.aligned->time.front();
  const Interval gps{p.aligned->time[lively->first], p.aligned->time[lively->last - 1]};
  const double to_reading = p.alignment->clock_offset - first;
  const Interval reading{gps.start + to_reading, gps.end + to_reading};
  out.push_back(as_figure(
      "before",
      two_norms("Before: the liveliest seconds of the body IMU, and the reference at the same reading", raw.label(),
                norms(*p.body, reading, body_time), norms(*p.reference, reading, reference_time)),
      "The same reading of both clocks is not the same time."));
  const auto after = [&](const auto& time) { return [&, time](const ImuSample& s) { return time(s) - origin; }; };
  const Interval window{gps.start - origin, gps.end - origin};
  out.push_back(
      as_figure("after",
                two_norms("After: the same seconds", kTimeLabel, norms(*p.body, window, after(aligned_time)),
                          norms(*p.reference, window, after([](const ImuSample& s) { return s.time; }))),
                "Offset and drift of the body IMU's clock taken away; nothing is filtered or turned, as norms do not "
                "depend on the axes."));
  return out;
}

std::vector<Figure> correlation_figures(const AlignmentPicture& p) {
  const CorrelationPeak& c = p.alignment->correlation;
  if (c.offset.empty()) return {};
  const auto draw = [&](const std::string& title, double from, double to) {
    Curve curve;
    for (std::size_t i = 0; i < c.offset.size(); ++i) {
      if (c.offset[i] < from || c.offset[i] > to) continue;
      curve.x.push_back(c.offset[i]);
      curve.y.push_back(c.correlation[i]);
    }
    Plot plot(title, {"clock offset, body IMU less reference [s]"}, {"correlation of the norms"});
    plot.size(Plot::kPageWidth, kSignalHeight);
    plot.line(curve.x, curve.y, kBodyColour, "");
    plot.mark(c.peak_offset, c.peak, kReferenceColour, fmt::format("{:.3f} at {:.3f} s", c.peak, c.peak_offset));
    return plot;
  };
  const auto [low, high] = std::minmax_element(c.offset.begin(), c.offset.end());
  return {as_figure(
              "correlation", draw("Every offset that was tried", *low, *high),
              fmt::format("Correlation of the norms of the angular rates. The highest elsewhere is {:.3f}.", c.rival)),
          as_figure("correlation_peak", draw("The peak", c.peak_offset - kAroundPeak, c.peak_offset + kAroundPeak),
                    "The same about the peak, which is where the fit begins.")};
}

std::vector<Figure> signal_figures(const AlignmentPicture& p) {
  const auto lively = liveliest(*p.aligned);
  if (!lively) return {};
  const AlignedImus smooth = low_passed(*p.aligned, p.low_pass);
  const std::string band = p.low_pass > 0 ? fmt::format("below {:.4g} Hz", p.low_pass) : "unfiltered";
  std::vector<double> time;
  for (std::size_t i = lively->first; i < lively->last; ++i) time.push_back(smooth.time[i] - smooth.time.front());
  std::vector<Figure> out;
  for (const Quantity& q : kQuantities) {
    const std::vector<Vector3d> left = left_over(q, smooth, *p.alignment);
    const auto axis_of = [&](const std::vector<Vector3d>& series, int axis) {
      std::vector<double> values;
      for (std::size_t i = lively->first; i < lively->last; ++i) values.push_back(q.factor * series[i](axis));
      return values;
    };
    const std::string y_label = fmt::format("{} [{}]", q.name, q.unit);
    Plot rest(fmt::format("Residual of {}", q.name), {kTimeLabel}, {y_label});
    rest.size(Plot::kPageWidth, kSignalHeight);
    for (int axis = 0; axis < 3; ++axis) {
      const auto name = kAxes[static_cast<std::size_t>(axis)];
      Plot plot(fmt::format("{} along {}, {}", is_rate(q) ? "Angular rate" : "Specific force", name, band),
                {kTimeLabel}, {y_label});
      plot.size(Plot::kPageWidth, kSignalHeight);
      plot.line(time, axis_of(smooth.*q.body, axis), kBodyColour, "body IMU");
      plot.line(time, axis_of(smooth.*q.reference, axis), kReferenceColour, "reference, turned and moved",
                Plot::Stroke::kDashed);
      plot.line(time, axis_of(left, axis), kLeftColour, "residual");
      out.push_back(as_figure(fmt::format("{}_{}", q.stem, name), plot, ""));
      rest.line(time, axis_of(left, axis), axis, std::string(name));
    }
    out.push_back(
        as_figure(fmt::format("{}_left", q.stem), rest,
                  "Body IMU less reference, less the bias and scale that the alignment found; on its own scale."));
  }
  return out;
}

std::vector<Figure> spectrum_figures(const AlignmentPicture& p) {
  const AlignedImus& imus = *p.aligned;
  std::size_t longest = 0;
  for (const Stretch& s : usable_stretches(imus)) longest = std::max(longest, s.size());
  std::size_t segment = 4;
  while (2 * segment <= longest && static_cast<double>(2 * segment) * imus.interval <= kSegment) segment *= 2;
  if (segment > longest) return {};
  std::vector<Figure> out;
  for (const Quantity& q : kQuantities) {
    double low = std::numeric_limits<double>::infinity(), high = 0;
    const auto curve = [&](const std::vector<Vector3d>& signal) {
      const Spectrum s = welch(signal, imus.usable, imus.interval, segment);
      Curve out_curve;
      for (std::size_t k = 1; k + 1 < s.frequency.size(); ++k) {  // without the mean and without the highest frequency
        out_curve.x.push_back(s.frequency[k]);
        out_curve.y.push_back(q.factor * q.factor * s.density[k].mean());
        low = std::min(low, out_curve.y.back());
        high = std::max(high, out_curve.y.back());
      }
      return out_curve;
    };
    const Curve own = curve(imus.*q.body), left = curve(left_over(q, imus, *p.alignment));
    const double noise = q.factor * (is_rate(q) ? p.sensor.gyro.noise : p.sensor.accel.noise);
    const double level = 2 * noise * noise;
    Plot plot(fmt::format("Spectrum of {}, mean of three axes", q.name), {"frequency [Hz]", {}, true},
              {fmt::format("[({})²/Hz]", q.unit), {}, true});
    plot.size(Plot::kPageWidth, kSignalHeight + 60);
    plot.line(own.x, own.y, kBodyColour, "body IMU");
    plot.line(left.x, left.y, kLeftColour, "residual");
    if (level > 0) {
      plot.line({own.x.front(), own.x.back()}, {level, level}, kKnownColour, "noise in the sensor file",
                Plot::Stroke::kDashed);
    }
    if (p.low_pass > 0) upright(plot, p.low_pass, low, high, "low-pass");
    out.push_back(
        as_figure(fmt::format("{}_spectrum", q.stem), plot,
                  "One-sided, unfiltered, over the whole log. Where the residual lies above the noise, the two "
                  "IMUs differ by more than the noise of the one; quantised increments of the reference are a "
                  "slope that rises with frequency."));
  }
  return out;
}

std::vector<Figure> drift_figures(const AlignmentPicture& p) {
  const Alignment& a = *p.alignment;
  if (a.local.empty()) return {};
  const double origin = p.aligned->time.front();
  // Offsets with their whiskers: relative to the alignment, and absolute.
  struct Bars {
    std::vector<double> offset, low, high;
    void add(double value, double sigma) {
      offset.push_back(kMillisecondsPerSecond * value);
      low.push_back(kMillisecondsPerSecond * (value - sigma));
      high.push_back(kMillisecondsPerSecond * (value + sigma));
    }
  } relative, whole;
  std::vector<double> time;
  for (const LocalOffset& l : a.local) {
    time.push_back(l.time - origin);
    relative.add(l.offset, l.sigma);
    whole.add(l.offset + a.clock_drift * time.back(), l.sigma);
  }
  const double end = p.aligned->time.back() - origin;
  // The stretches with small sigmas set the scale of the axis.
  double best = std::numeric_limits<double>::infinity(), reach = 0;
  for (const LocalOffset& l : a.local) best = std::min(best, l.sigma);
  for (const LocalOffset& l : a.local) {
    if (l.sigma <= kInformative * best) reach = std::max(reach, std::abs(l.offset) + 2 * l.sigma);
  }
  std::vector<double> grid, fitted, low, high;
  constexpr int kSteps = 50;
  for (int i = 0; i <= kSteps; ++i) {
    const double t = end * i / kSteps;
    constexpr int kOffset = AlignmentLayout::kClockOffset, kDrift = AlignmentLayout::kClockDrift;
    const double sigma =
        std::sqrt(a.variance(kOffset) + 2 * t * a.covariance(kOffset, kDrift) + t * t * a.variance(kDrift));
    grid.push_back(t);
    fitted.push_back(kMillisecondsPerSecond * a.clock_drift * t);
    low.push_back(-kMillisecondsPerSecond * sigma);
    high.push_back(kMillisecondsPerSecond * sigma);
  }
  Plot all("Clock of the body IMU: offset since the first sample", {kTimeLabel}, {"offset [ms]"});
  all.size(Plot::kPageWidth, kSignalHeight);
  all.line(grid, fitted, kAlignmentColour, fmt::format("drift of {:.2f} ppm", 1e6 * a.clock_drift));
  all.bars(time, whole.offset, whole.low, whole.high, kBodyColour, "stretches of the log, ± 1 sigma");
  Plot apart("The same, relative to the alignment", {kTimeLabel}, {"offset [ms]"});
  apart.size(Plot::kPageWidth, kSignalHeight);
  apart.limit_y(-kMillisecondsPerSecond * reach, kMillisecondsPerSecond * reach);
  apart.band(grid, low, high, kAlignmentColour, "alignment, ± 1 sigma");
  apart.bars(time, relative.offset, relative.low, relative.high, kBodyColour, "stretches of the log, ± 1 sigma");
  return {
      as_figure("clock_drift", all, "Each point is the offset by one stretch of the log alone."),
      as_figure(
          "clock_residual", apart,
          "A clock that runs evenly leaves points that scatter about zero as their bars say. The scale is that of the "
          "most informative stretches; bars of the others, at rest, reach beyond.")};
}

std::vector<Figure> alignment_figures(const AlignmentPicture& picture) {
  std::vector<Figure> out;
  for (const auto of : {clock_figures, correlation_figures, signal_figures, spectrum_figures, drift_figures}) {
    std::vector<Figure> more = of(picture);
    std::move(more.begin(), more.end(), std::back_inserter(out));
  }
  return out;
}

}  // namespace piste
