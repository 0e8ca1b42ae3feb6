#pragma once
/// The low-pass filter for the signals of two IMUs that are to be compared: Butterworth, in a form without delay and in
/// a causal form. docs/low_pass.md explains the choice.

#include <array>
#include <complex>
#include <span>
#include <vector>

#include "piste/math/so3.h"

namespace piste {

/// Butterworth low-pass as a cascade of sections of second order and at most one of first order. The bilinear transform
/// is pre-warped so that the gain is −3 dB at the cut-off. With the warped frequency Ω = tan(π f / rate) / tan(π cutoff
/// / rate):
///
///     |H|² = 1 / (1 + Ω^(2 order)),     H = Π_j 1 / (1 + damping_j iΩ − Ω²) [· 1 / (1 + iΩ)]
///
/// The sections integrate by the trapezoidal rule (Zavalishin, The Art of VA Filter Design, chapters 3 and 4). They
/// have the same transfer functions as biquads. But their coefficients and states do not cancel at cut-offs far below
/// the rate. The steady state is the input itself, so that a constant passes unchanged to the last bit.
class LowPass {
 public:
  static constexpr int kMaxOrder = 12;

  /// `cutoff` and `rate` in Hz. Throws ConfigError unless 0 < cutoff < rate / 2 and 1 ≤ order ≤ kMaxOrder.
  LowPass(double cutoff, double rate, int order = 4);

  /// H at `frequency` [Hz], of the causal filter; forward and backward it is |H|², which is real.
  std::complex<double> response(double frequency) const;
  /// Group delay −dφ/dω of the causal filter at `frequency` [Hz], in seconds.
  double delay(double frequency) const;
  /// Number of samples, about, after which a disturbance has fallen to 1e-9 of itself. Not rounded, as it may exceed
  /// any integer.
  double settling() const { return settling_; }

  /// A section 1 / (s² + damping s + 1) with s = (1/g) (z − 1) / (z + 1) and g = tan(π cutoff / rate).
  struct Section {
    double damping;
    double a1, a2, a3;  ///< 1 / (1 + damping g + g²), and times g, and times g²
  };
  /// The sections of second order: order / 2 of them.
  std::span<const Section> sections() const { return {sections_.data(), static_cast<std::size_t>(order_ / 2)}; }
  /// A section 1 / (s + 1) follows where the order is odd; its coefficient is g / (1 + g).
  bool has_first_order() const { return order_ % 2 == 1; }
  double first_order() const { return first_order_; }

 private:
  double rate_, g_;
  int order_;
  std::array<Section, kMaxOrder / 2> sections_{};
  double first_order_;
  double settling_;
};

/// Causal low-pass for real time: takes one sample at a time, at the filter's rate, without heap. It starts in the
/// steady state of its first sample. @pre samples are finite: NaN would spoil all later output.
class CausalLowPass {
 public:
  explicit CausalLowPass(const LowPass& filter) : filter_(filter) {}

  Vector3d add(const Vector3d& sample);
  /// Delay [s] of a component of this frequency [Hz]: LowPass::delay.
  double delay(double frequency) const { return filter_.delay(frequency); }

 private:
  struct State {
    Vector3d first, second;  // of the two integrators
  };
  LowPass filter_;
  bool started_ = false;
  std::array<State, LowPass::kMaxOrder / 2> states_;
  Vector3d last_;  // state of the section of first order
};

/// Filters forward and then backward. There is no delay at any frequency, and the gain is |H|², which is one half (−6
/// dB) at the cut-off. Samples are equally spaced, at the filter's rate. The result has as many samples.
///
/// Edges are treated as in scipy.signal.sosfiltfilt. The signal is extended beyond its ends by its own point reflection
/// (odd extension), and each pass starts in the steady state of its first sample. A constant passes unchanged. The
/// extension is as long as the filter takes to settle, or as long as the signal allows. So a straight line passes to
/// 1e-9 if the signal is longer than `settling()`. (By default scipy extends by a few samples only, however low the
/// cut-off; its `padlen` gives the same.) @pre samples are finite. Source: Gustafsson 1996, Determining the initial
/// states in forward-backward filtering, IEEE Trans. SP 44.
std::vector<Vector3d> zero_phase(const LowPass& filter, std::span<const Vector3d> signal);

}  // namespace piste
