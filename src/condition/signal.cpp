#include "piste/condition/signal.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "piste/core/error.h"
#include "piste/math/interruption.h"

namespace piste {
namespace {

using std::numbers::pi;

constexpr double kSettled = 1e-9;

}  // namespace

LowPass::LowPass(double cutoff, double rate, int order) : rate_(rate), g_(std::tan(pi * cutoff / rate)), order_(order) {
  if (!(std::isfinite(rate) && 0 < cutoff && cutoff < rate / 2)) {
    throw ConfigError("", fmt::format("low pass: a cut-off of {} Hz at a rate of {} Hz; it must be above 0 and below "
                                      "half the rate",
                                      cutoff, rate));
  }
  if (order < 1 || order > kMaxOrder) {
    throw ConfigError("", fmt::format("low pass: order {}; it must be 1 to {}", order, kMaxOrder));
  }
  // Poles z of a section, damping / 2 being their distance from the imaginary axis:
  // |z|² = (1 − damping g + g²) / (1 + damping g + g²). The slowest one decides.
  double log_radius = -std::numeric_limits<double>::infinity();
  for (int j = 0; j < order / 2; ++j) {
    const double damping = 2 * std::sin((2 * j + 1) * pi / (2 * order));
    const double a1 = 1 / (1 + damping * g_ + g_ * g_);
    sections_[j] = {damping, a1, a1 * g_, a1 * g_ * g_};
    log_radius = std::max(log_radius, std::log1p(-2 * damping * g_ * a1) / 2);
  }
  first_order_ = g_ / (1 + g_);
  if (has_first_order()) log_radius = std::max(log_radius, -2 * std::atanh(std::min(g_, 1 / g_)));  // |1 − g| / (1 + g)
  settling_ = order + std::log(kSettled) / log_radius;
}

std::complex<double> LowPass::response(double frequency) const {
  const double w = std::tan(pi * frequency / rate_) / g_;
  std::complex<double> denominator(1, has_first_order() ? w : 0);
  for (const Section& section : sections()) denominator *= std::complex<double>(1 - w * w, section.damping * w);
  return 1.0 / denominator;
}

double LowPass::delay(double frequency) const {
  // Each phase is −atan(damping Ω / (1 − Ω²)), or −atan Ω, and dΩ/dω = (1 + tan²) / (2 rate g).
  const double t = std::tan(pi * frequency / rate_), w = t / g_;
  double slope = has_first_order() ? 1 / (1 + w * w) : 0;
  for (const Section& section : sections()) {
    const double damped = section.damping * w, stiff = 1 - w * w;
    slope += section.damping * (1 + w * w) / (stiff * stiff + damped * damped);
  }
  return slope * (1 + t * t) / (2 * rate_ * g_);
}

Vector3d CausalLowPass::add(const Vector3d& sample) {
  const auto sections = filter_.sections();
  if (!started_) {
    started_ = true;
    states_.fill({Vector3d::Zero(), sample});
    last_ = sample;
  }
  Vector3d signal = sample;
  for (std::size_t j = 0; j < sections.size(); ++j) {
    const LowPass::Section& c = sections[j];
    State& state = states_[j];
    const Vector3d change = signal - state.second;
    const Vector3d slope = c.a1 * state.first + c.a2 * change;
    signal = state.second + c.a2 * state.first + c.a3 * change;
    state = {2 * slope - state.first, 2 * signal - state.second};
  }
  if (filter_.has_first_order()) {
    const Vector3d step = filter_.first_order() * (signal - last_);
    signal = last_ + step;
    last_ = signal + step;
  }
  return signal;
}

std::vector<Vector3d> zero_phase(const LowPass& filter, std::span<const Vector3d> signal) {
  check_interruption();
  if (signal.empty()) return {};
  const std::size_t n = signal.size();
  const auto edge = static_cast<std::size_t>(std::min(std::ceil(filter.settling()), static_cast<double>(n - 1)));
  std::vector<Vector3d> extended;
  extended.reserve(n + 2 * edge);
  for (std::size_t k = edge; k > 0; --k) extended.emplace_back(2 * signal.front() - signal[k]);
  extended.insert(extended.end(), signal.begin(), signal.end());
  for (std::size_t k = 1; k <= edge; ++k) extended.emplace_back(2 * signal.back() - signal[n - 1 - k]);

  CausalLowPass forward(filter), backward(filter);
  for (Vector3d& sample : extended) sample = forward.add(sample);
  std::for_each(extended.rbegin(), extended.rend(), [&](Vector3d& sample) { sample = backward.add(sample); });
  return {extended.begin() + static_cast<std::ptrdiff_t>(edge),
          extended.begin() + static_cast<std::ptrdiff_t>(edge + n)};
}

}  // namespace piste
