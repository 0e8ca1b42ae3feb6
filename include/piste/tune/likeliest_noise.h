#pragma once
/// Noise by likelihood: how noisy the sensors of a run are, by the innovations of the filter that navigates with them.
/// docs/tune.md is an introduction.
///
/// Sought is the maximum of −½ Σ (zᵀ S⁻¹ z + ln det S) over the innovations z of receivers and reference attitudes, S
/// their covariance by the filter (Schweppe 1965), plus a weak prior about the values at the start: each number is
/// log-normal, with a 1-sigma of a factor of 10 (sizes) or of 3 (correlation times). It holds the numbers that the data
/// do not determine. For the others it has the weight of a single observation at most.

#include <cstddef>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "piste/core/log.h"
#include "piste/core/options.h"
#include "piste/filter/run.h"
#include "piste/tune/standing_heights.h"

namespace piste {

/// The errors of one receiver, relative to the sigmas that it states.
struct ReceiverNoise {
  double white = 1, velocity = 1;    ///< factors of its sigmas: of the white error of positions, and of velocities
  double height = 1;                 ///< an additional factor of those of heights, white and coloured
  double drift = 0, drift_time = 0;  ///< coloured error of positions: factor of `drift_shape` (0: none), and time [s]
  Vector3d drift_shape, stated;      ///< of a drift of factor 1; median of the sigmas of positions that it states
  StandingHeights standing = {};     ///< what rounding makes of its heights at least
  /// The limit of the white error where the drift is a share of the sigmas [m] (PositionDrift).
  double most_white = std::numeric_limits<double>::infinity();
  bool in_metres = false;  ///< whether its drift is stated in m, and not as a share of its sigmas
  bool is_white = false;   ///< whether the user says so: the total may then be less than is stated
  bool by_claim = false;   ///< whether its drift is what the innovations leave of the stated sigmas

  /// Factor of the sigmas of positions by which they are those of white and coloured error together.
  double position() const;
  /// The factors of all sigmas that it states, with the additional one of heights.
  SigmaScales scales() const;
  /// The coloured error, if there is one; heights that stand still have one, which lasts.
  std::optional<PositionDrift> process() const;
  /// Its 1-sigma where the receiver states the median of its sigmas [m]; 0 if there is none.
  Vector3d slow() const;
};

/// The noise of a run's sensors.
struct NoiseModel {
  ImuSensor sensor;
  std::vector<ReceiverNoise> gnss;    ///< one per receiver
  std::vector<double> attitude_time;  ///< correlation time of each reference attitude's errors; 0: white
};

/// One number that was sought.
struct TunedNoise {
  std::string name;  ///< such as `gyro.noise` or `gnss[0].sigma_scale`
  std::string unit;  ///< of the values here; empty: a factor
  double start = 0, value = 0;
  double low = 0, high = 0;  ///< its 95 % interval, by the likelihood and the prior
  /// Whether the data determine it: they halved the prior's 1-sigma at least, and the interval is within a factor of 3.
  bool determined = false;
  double prior = 0;  ///< 1-sigma of its logarithm about `start` before any data; 0: not known
};

/// Mean normalised innovation squared of a source, per row: 1 where the sigmas are right. Of the stretches that were
/// held out, or of all.
struct SourceNis {
  std::string source;
  std::size_t innovations = 0;
  double mean = 0;
  double error = 0;  ///< standard error of the mean: how far it may be from 1 by chance
};

/// White noise of the samples at rest, for comparison with the noise in motion: [rad/s/√Hz], [m/s²/√Hz].
struct NoiseAtRest {
  double gyro = 0, accel = 0;  ///< largest axis; NaN without a rest of two seconds
};

/// The result. In both models the total error of positions is what a receiver states at least (tune/stated_errors.h).
struct Tuning {
  NoiseModel noise;
  /// The same with the mean variance of each white noise and drift of the IMU instead of its mode, the
  /// maximum-likelihood one: σ exp(s²), s the 1-sigma of ln σ. It is at most twice as large, and within the noise of
  /// the samples. A noise that the data hardly determine is then not too low.
  NoiseModel expected;
  std::vector<TunedNoise> numbers;
  double likelihood_at_start = 0, likelihood = 0;  ///< without the prior
  std::size_t rows = 0, filter_runs = 0;           ///< rows of innovations in a run; runs of the filter
  /// By how much the likelihood rose with a coloured error of the first receiver, and how much it had to rise (Schwarz
  /// 1978: half the number of its parameters times ln rows). Nothing if it was stated, or could not be tried.
  std::optional<double> drift_gain = std::nullopt;
  double drift_penalty = 0;
  /// The same of a limit of the white error of the first receiver, where it states sigmas of different kinds of fixes.
  std::optional<double> kinds_gain = std::nullopt;
  double kinds_penalty = 0;
  std::vector<SourceNis> nis;
  double held_out = 0;  ///< length of the stretches that were held out, and are in `nis` alone [s]; 0: none were
  NoiseAtRest at_rest;
};

struct TuneOptions {
  std::size_t jobs = 1;  ///< filter runs at a time; the result does not depend on it
  /// Whether a coloured error of the first receiver is tried where none is stated. It is kept if the likelihood rises
  /// by more than its penalty.
  bool try_drift = true;
  /// Whether the search goes on until nothing is gained, and intervals are by second differences of the likelihood
  /// (some n² runs for n numbers). Else it is rougher, at a quarter of the cost.
  bool thorough = true;
  /// Of each two stretches of this length [s] the second is held out: nothing is fitted to its innovations, and
  /// Tuning::nis is theirs alone. 0: none is.
  double hold_out = 0;
  /// Of each receiver the sigmas of positions that it states, by those of the log, north, east, down; 1 where missing.
  std::vector<Vector3d> stated = {};
};

/// What a receiver states by the sigmas of a log in which they were multiplied by `factors`: no more than those of the
/// log, as who makes them smaller says so.
Vector3d stated_before(const SigmaScales& factors);

/// Runs of the filter that a rough search and a thorough one take as a rule.
inline constexpr double kRoughRuns = 100, kThoroughRuns = 400;

/// Estimates the maximum-likelihood noise of a log with a known start. The numbers are those that the options have:
/// none of a drift without a process, and no scale of velocities that a receiver lacks. `at_rest` is not filled in.
/// Where rounding makes heights of the first receiver stand still, and their sigma comes out no larger than that of the
/// rounding (standing_heights.h), all is sought again with its errors as the least that they have. Where a coloured
/// error was found, its heights get that least without another search.
/// Throws DataError if no innovation is later than 5 s after the start.
/// @pre `options` is what with_white_part() returns.
Tuning likeliest_noise(const Log& log, const FilterOptions& options, const Start& start, const TuneOptions& how = {},
                       const ProgressCallback& progress = {});

}  // namespace piste
