#pragma once
/// Converts a fitted noise model to a sensor file: the numbers of data sheets, and the processes that the filter can
/// represent.

#include <array>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "piste/allan/gmwm.h"
#include "piste/core/sensor.h"

namespace piste {

/// Noise with a shorter correlation counts as white noise: between two fixes of a receiver the two cannot be separated.
inline constexpr double kFastTime = 1;  // s

/// Such as `deg/s/sqrt(Hz)`: the unit in which the size of a process is shown, and how many SI units it is.
struct ProcessUnit {
  std::string name;
  double factor = 1;
};
ProcessUnit unit_of(ProcessKind kind, bool gyro);

/// A number with its interval.
struct Measured {
  double value = 0, low = 0, high = 0;
  double sigma_log = 0;  ///< standard deviation of its logarithm
};

/// The numbers of one axis, in SI.
struct AxisNoise {
  /// Density of the white noise [unit/√Hz] for a filter. Its square is the sum of the model's white noise N², of 2 σ² T
  /// for Gauss-Markov processes shorter than kFastTime, and of 3 Q² / kFastTime for quantisation. Where no model
  /// describes the curve, it is scaled to the measured curve from kFastTime on, at the scales that this noise
  /// dominates.
  Measured noise;
  /// Bias instability [unit]: the flicker noise of the model; without one, the lowest deviation over 0.664, which is
  /// flicker noise or less (IEEE Std 952).
  Measured instability;
  double instability_tau = 0;       ///< where the lowest deviation is [s]
  bool flicker = false;             ///< whether the model has flicker noise
  bool lowest_inside = true;        ///< false: the curve falls to its end, and the value is an upper bound
  std::vector<NoiseProcess> drift;  ///< the other processes: flicker, random walk, ramp, slow Gauss-Markov
};

AxisNoise axis_noise(const GmwmFit& fit, const AllanCurve& curve, double probability = 0.95);

/// The step of which all values are multiples, as an analogue-to-digital converter or the digits of a file leave them;
/// 0 if there is none.
double value_step(std::span<const double> values);
/// Density of the white noise that rounding to such a step adds: step / √12 · √interval.
double rounding_noise(double step, double interval);

/// Samples that lie farther than `sigmas` robust sigmas from the median of the 64 around; their places, ascending. Of
/// samples of a normal distribution one in a thousand million does at 6.
std::vector<std::size_t> outlying(std::span<const double> values, double sigmas = 6);
/// The same, and puts the median in their place.
std::size_t replace_outlying(std::vector<double>& values, double sigmas = 6);

/// The one drift process of a sensor file nearest to the drifts of several axes. It is the least-squares fit to the
/// logarithm of the mean Allan variance over the scales from kFastTime to `longest`, weighted by its share of the
/// whole. None if there is no drift. A single process that a filter can represent is taken unchanged.
struct NearestDrift {
  DriftProcess process;
  double off = 0;  ///< largest error of its deviation where the drift is at least a fifth of the whole, as a ratio
  std::string why;
};
NearestDrift nearest_drift(std::span<const AxisNoise> axes, double shortest, double longest);

/// Whether numbers of several axes or IMUs differ by more than chance: p-value of equal values, by the logarithms.
double equal_p_value(std::span<const Measured> values);

/// The spread of a number between IMUs of one type: standard deviation of its logarithm in excess of the intervals
/// (DerSimonian and Laird 1986, by moments).
double spread_between(std::span<const Measured> values);

}  // namespace piste
