#include "paired_signals.h"

#include <algorithm>
#include <cmath>

#include "piste/condition/signal.h"
#include "piste/math/statistics.h"

namespace piste {

ReferenceIntegrals::ReferenceIntegrals(const std::vector<ImuSample>& imu) {
  time_.reserve(imu.size() + 1);
  angle_.reserve(imu.size() + 1);
  velocity_.reserve(imu.size() + 1);
  time_.push_back(imu.front().time - imu.front().interval);
  angle_.emplace_back(Vector3d::Zero());
  velocity_.emplace_back(Vector3d::Zero());
  for (const ImuSample& s : imu) {
    time_.push_back(s.time);
    angle_.emplace_back(angle_.back() + s.dtheta);
    velocity_.emplace_back(velocity_.back() + s.dvel);
    if (!s.gap) continue;
    const double from = s.time - s.interval;
    if (!gaps_.empty() && gaps_.back().end >= from) {
      gaps_.back().end = s.time;
    } else {
      gaps_.push_back({from, s.time});
    }
  }
  angle_spline_ = std::make_unique<Spline>(time_, angle_);
  velocity_spline_ = std::make_unique<Spline>(time_, velocity_);
}

std::size_t ReferenceIntegrals::index(double t) const {
  const auto after = std::upper_bound(time_.begin() + 1, time_.end() - 1, t);
  return static_cast<std::size_t>(after - time_.begin()) - 1;
}

MeanSignal ReferenceIntegrals::mean(double t, double interval) const {
  const double from = t - interval, middle = t - interval / 2;
  const std::size_t i = index(from), j = index(middle), k = index(t);
  const Vector3d w_from = angle_spline_->derivative(i, from), w_middle = angle_spline_->derivative(j, middle),
                 w_to = angle_spline_->derivative(k, t);
  // Simpson's rule for the mean of [w]ₓ² = w wᵀ − |w|² I; the mean of w' is exact.
  const auto square = [](const Vector3d& w) -> Matrix3d {
    return w * w.transpose() - w.squaredNorm() * Matrix3d::Identity();
  };
  return {(angle_spline_->value(k, t) - angle_spline_->value(i, from)) / interval,
          (velocity_spline_->value(k, t) - velocity_spline_->value(i, from)) / interval,
          skew((w_to - w_from) / interval) + (square(w_from) + 4 * square(w_middle) + square(w_to)) / 6};
}

bool ReferenceIntegrals::silent(double from, double to) const {
  const auto gap = std::partition_point(gaps_.begin(), gaps_.end(), [&](const Interval& g) { return g.end <= from; });
  return gap != gaps_.end() && gap->start < to;
}

ReferenceGrid::ReferenceGrid(const ReferenceIntegrals& reference, double step) {
  auto time = std::make_shared<std::vector<double>>();
  auto values = std::make_shared<std::array<std::vector<Vector3d>, kChannels>>();
  const auto cells = static_cast<std::size_t>((reference.end() - reference.start()) / step);
  for (std::size_t i = 1; i <= cells; ++i) {
    time->push_back(std::min(reference.end(), reference.start() + static_cast<double>(i) * step));
    const MeanSignal signal = reference.mean(time->back(), step);
    (*values)[0].push_back(signal.gyro);
    (*values)[1].push_back(signal.accel);
    for (std::size_t c = 0; c < 3; ++c) (*values)[2 + c].emplace_back(signal.lever.col(static_cast<Eigen::Index>(c)));
  }
  time_ = std::move(time);
  values_ = std::move(values);
  make_splines();
}

ReferenceGrid::ReferenceGrid(std::shared_ptr<const std::vector<double>> time,
                             std::array<std::vector<Vector3d>, kChannels> values)
    : time_(std::move(time)),
      values_(std::make_shared<const std::array<std::vector<Vector3d>, kChannels>>(std::move(values))) {
  make_splines();
}

void ReferenceGrid::make_splines() {
  for (const auto& channel : *values_) splines_.emplace_back(*time_, channel);
}

ReferenceGrid ReferenceGrid::filtered(const TriadFilters& filters) const {
  std::array<std::vector<Vector3d>, kChannels> values;
  for (std::size_t c = 0; c < kChannels; ++c) values[c] = (c == 0 ? filters.gyro : filters.accel)((*values_)[c]);
  return {time_, std::move(values)};
}

ReferenceGrid::Value ReferenceGrid::at(double t) const {
  const std::vector<double>& time = *time_;
  const double step = time[1] - time[0];
  const auto last = static_cast<std::ptrdiff_t>(time.size()) - 2;
  const auto i = static_cast<std::size_t>(
      std::clamp<std::ptrdiff_t>(static_cast<std::ptrdiff_t>((t - time.front()) / step), 0, last));
  Value v;
  v.signal.gyro = splines_[0].value(i, t);
  v.slope.gyro = splines_[0].derivative(i, t);
  v.signal.accel = splines_[1].value(i, t);
  v.slope.accel = splines_[1].derivative(i, t);
  for (int c = 0; c < 3; ++c) {
    const Spline& column = splines_[2 + static_cast<std::size_t>(c)];
    v.signal.lever.col(c) = column.value(i, t);
    v.slope.lever.col(c) = column.derivative(i, t);
  }
  return v;
}

BodySignals::BodySignals(const std::vector<ImuSample>& imu) {
  std::vector<double> intervals;
  for (const ImuSample& s : imu) {
    time.push_back(s.time);
    gyro.emplace_back(s.dtheta / s.interval);
    accel.emplace_back(s.dvel / s.interval);
    const auto not_in = [&](std::uint8_t clipped) {
      return static_cast<std::uint8_t>(s.gap || s.interpolated ? 0 : 7 & ~clipped);
    };
    usable.push_back({not_in(s.clipped_gyro), not_in(s.clipped_accel)});
    intervals.push_back(s.interval);
  }
  step = median(std::move(intervals));
}

BodySignals BodySignals::filtered(const TriadFilters& filters) const {
  BodySignals out = *this;
  out.gyro = filters.gyro(gyro);
  out.accel = filters.accel(accel);
  const auto reach_before = static_cast<std::ptrdiff_t>(std::ceil(filters.before / step)),
             reach_after = static_cast<std::ptrdiff_t>(std::ceil(filters.after / step));
  const auto count = static_cast<std::ptrdiff_t>(usable.size());
  for (std::ptrdiff_t i = 0; i < count; ++i) {
    const UsableAxes axes = usable[static_cast<std::size_t>(i)];
    if (axes.gyro == 7 && axes.accel == 7) continue;
    // An unusable sample i makes those unusable whose filter reaches back or ahead to it.
    const std::ptrdiff_t last = std::min(count - 1, i + reach_before);
    for (std::ptrdiff_t k = std::max<std::ptrdiff_t>(0, i - reach_after); k <= last; ++k) {
      UsableAxes& here = out.usable[static_cast<std::size_t>(k)];
      here.gyro &= axes.gyro;
      here.accel &= axes.accel;
    }
  }
  return out;
}

SignalPair::SignalPair(const std::vector<ImuSample>& body_imu, const std::vector<ImuSample>& reference_imu)
    : body(body_imu), integrals(reference_imu), reference(integrals, body.step) {}

FilteredPair low_passed(const SignalPair& signals, double cutoff) {
  constexpr double kSmear = 2;  // reach of a zero-phase low-pass, in periods of the cut-off
  const double rate = 1 / signals.body.step, reach = kSmear / cutoff;
  const LinearFilter filter = [low_pass = LowPass(cutoff, rate)](std::span<const Vector3d> signal) {
    return zero_phase(low_pass, signal);
  };
  const TriadFilters filters{filter, filter, reach, reach};
  return {.body = signals.body.filtered(filters),
          .reference = signals.reference.filtered(filters),
          .margin = reach,
          .stride = std::max<std::size_t>(1, static_cast<std::size_t>(std::lround(rate / (2 * cutoff))))};
}

}  // namespace piste
