#include "tune/stated_errors.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "core/receiver_class.h"

namespace piste {
namespace {

constexpr double kPlaceholder = 20;  // m: GPS alone has 17 m of height at its worst site (receiver_class.h)
constexpr double kLongest = 7200;    // s: a satellite is in view for hours
constexpr double kLevel = 0.01;      // of the white error: a slow one that is next to none

// By which factor the white part of a receiver may be larger than was found.
double reach_of(std::size_t receiver, const std::vector<NoiseKnob>& knobs, const std::vector<LogInterval>& intervals) {
  for (std::size_t k = 0; k < knobs.size(); ++k) {
    if (knobs[k].name == fmt::format("gnss[{}].sigma_scale", receiver)) return std::exp(intervals[k].high);
  }
  return 1;
}

}  // namespace

Vector3d stated_before(const SigmaScales& factors) {
  const double level = std::min(1.0, 1 / factors.position);
  return {level, level, std::min(1.0, 1 / (factors.position * factors.height))};
}

ReceiverNoise with_stated_total(ReceiverNoise noise, const Vector3d& stated, double reach) {
  if (noise.is_white) return noise;
  Vector3d least = stated.cwiseProduct(noise.stated);
  const Vector3d single = receiver_class(FixQuality::kSingle).sigma();
  for (int axis = 0; axis < 3; ++axis) {
    if (least(axis) > kPlaceholder) least(axis) = single(axis);
  }
  const double whole = least.head<2>().mean() / noise.stated.head<2>().mean();
  if (!(noise.drift > 0) && noise.white < whole && noise.white * reach >= whole) noise.white = whole;
  const Vector3d white = noise.white * Vector3d(noise.stated.x(), noise.stated.y(), noise.height * noise.stated.z());
  Vector3d slow = noise.slow();
  bool more = false;
  for (int axis = 0; axis < 3; ++axis) {
    constexpr double kAsMuch = 1 - 1e-9;
    if (std::hypot(white(axis), slow(axis)) >= kAsMuch * least(axis)) continue;
    slow(axis) = std::sqrt(least(axis) * least(axis) - white(axis) * white(axis));
    more = true;
  }
  if (!more) return noise;
  if (!(noise.drift > 0)) {
    noise.drift_time = kSlowTime;
    noise.by_claim = true;
  }
  noise.drift = 1;
  noise.drift_shape = slow.cwiseMax(kLevel * white);
  noise.drift_shape.z() /= noise.height;
  return noise;
}

NoiseModel with_stated_totals(NoiseModel model, const std::vector<Vector3d>& stated,
                              const std::vector<NoiseKnob>& knobs, const std::vector<LogInterval>& intervals,
                              const NoiseSearch& search, const JudgedLog& log) {
  const double width = kTimeWidth;
  constexpr std::array kTimes{1 / 3.0, 0.58, 1.0, 1.73, 3.0};  // of kSlowTime
  for (std::size_t i = 0; i < model.gnss.size(); ++i) {
    const ReceiverNoise found = model.gnss[i];
    const Vector3d parts = i < stated.size() ? stated[i] : Vector3d::Ones().eval();
    if (i >= kDriftingReceivers) {
      if (!found.is_white) model.gnss[i].white = std::max(found.white, parts.x());
      continue;
    }
    ReceiverNoise& receiver = model.gnss[i];
    receiver = with_stated_total(found, parts, reach_of(i, knobs, intervals));
    if (!(receiver.drift > 0) || receiver.slow() == found.slow()) continue;
    std::vector<NoiseModel> trials;
    std::vector<double> prior;
    const auto attempt = [&](double time) {
      trials.emplace_back(model).gnss[i].drift_time = time;
      prior.push_back(-0.5 * std::pow(std::log(time / kSlowTime) / width, 2));
    };
    if (found.drift > 0) {
      // Of an error that changes more slowly than the log can show, 2 σ²/τ alone is determined: how fast it walks away.
      const double larger = receiver.slow().head<2>().norm() / found.slow().head<2>().norm();
      attempt(found.drift_time);
      attempt(found.drift_time * larger * larger);
    }
    for (const double part : kTimes) attempt(part * kSlowTime);
    std::vector<NoisePoint> points = search.filtered(log, trials);
    const auto value = [&](std::size_t k) { return points[k].evidence.likelihood + prior[k]; };
    std::size_t best = 0;
    for (std::size_t k = 1; k < points.size(); ++k) {
      if (value(k) > value(best)) best = k;
    }
    // Fixes that differ by far less than what is stated show a time that is far longer.
    while (best + 1 == points.size() && trials.back().gnss[i].drift_time < kLongest) {
      attempt(kTimes.back() * trials.back().gnss[i].drift_time);
      points.push_back(search.filtered(log, trials.back()));
      if (value(points.size() - 1) > value(best)) best = points.size() - 1;
    }
    model = trials[best];
  }
  return model;
}

}  // namespace piste
