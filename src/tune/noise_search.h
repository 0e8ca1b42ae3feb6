#pragma once
/// The search for the maximum-likelihood noise of a conditioned log with a known start.

#include <Eigen/Core>
#include <atomic>
#include <cstddef>
#include <functional>
#include <mutex>
#include <vector>

#include "math/linear_algebra.h"
#include "tune/evidence.h"
#include "tune/noise_model.h"

namespace piste {

/// A noise, and the run with it.
struct NoisePoint {
  NoiseModel model;
  Evidence evidence;
  double value = 0;  ///< log-likelihood of the run and of the prior; −∞ where the filter diverges
};

/// What a search found.
struct NoiseFound {
  NoisePoint best;
  std::vector<NoiseKnob> knobs;
  Eigen::MatrixXd information;  ///< about the logarithms of their values, by the run and the prior
};

/// A log as a run judges it (spoilt_fixes.h), and a start with the delays that this run estimated, with their sigmas.
struct JudgedLog {
  Log log;
  Start start;
  FullError sigmas = FullError::Zero();
};

/// Filters a log again and again with other noise. The log and its start stay as they are.
class NoiseSearch {
 public:
  /// The values of `centre` are those about which the prior is. `thorough`: whether climb() goes on until nothing is
  /// gained, with all samples; else it is with sums of them (thinned.h). `jobs` runs at a time; the result does not
  /// depend on it. `fitted`: what the likelihood counts. `ran`: is called after each run with the number of runs so
  /// far, by one thread at a time.
  NoiseSearch(const Log& log, FilterOptions options, Start start, NoiseModel centre, bool thorough, std::size_t jobs,
              Stretches fitted = {}, std::function<void(std::size_t)> ran = {});

  /// A run of the log with the gate of the options.
  Evidence gated(const NoiseModel& model, const Stretches& counted = {}) const;

  /// The log as a run with this noise judges it.
  JudgedLog judged(const NoiseModel& model) const;

  /// A run that uses all fixes of `log` and holds the delays, as judged() returned both. What a run rejects changes by
  /// leaps, and where a delay is estimated, so does the sample of the IMU to which a fix belongs: the likelihood would
  /// leap with both.
  NoisePoint filtered(const JudgedLog& log, const NoiseModel& model) const;
  /// The same for several models.
  std::vector<NoisePoint> filtered(const JudgedLog& log, const std::vector<NoiseModel>& models) const;

  /// The maximum-likelihood noise near `from`, by Gauss and Newton in the logarithms: the gradient is a difference of
  /// the likelihood, and the curvature the information of Gaussian innovations z with sigmas σ, Σ (∂z ∂zᵀ/σ² + 2 ∂ln σ
  /// ∂ln σᵀ) over their rows, from the same runs (the method of scoring; Gupta and Mehra 1974). S counts in it as if it
  /// were diagonal. The same changes carry the gradient along for two steps more. Outliers and delays are sought anew
  /// when it has arrived, until they stay the same; outliers once, unless it is thorough. Throws DataError if no noise
  /// that is tried lets the filter run.
  NoiseFound climb(const NoiseModel& from) const;

  /// The same with one knob `held` for each of some runs of `log`, by one step: what is likelier than the run, or the
  /// run itself.
  std::vector<NoisePoint> climbed(const JudgedLog& log, const std::vector<NoiseKnob>& knobs,
                                  std::vector<NoisePoint> from, const std::vector<std::size_t>& held) const;

  /// Number of filter runs so far.
  std::size_t runs() const { return runs_; }

 private:
  struct Ascent {
    Eigen::VectorXd slope;
    Eigen::MatrixXd information;
    // Of which run, and how its residuals and sigmas change with each knob.
    std::vector<Innovation> innovations;
    Eigen::MatrixXd changes;

    /// What a whole step gains where the likelihood is a parabola.
    double gain() const { return 0.5 * slope.dot(solve_symmetric(information, slope)); }
    /// The step to the top of the parabola, none of its parts longer than `most`.
    Eigen::VectorXd step(double most) const;
    void hold(const std::vector<NoiseKnob>& knobs, const NoiseModel& model);
  };
  Ascent ascent(const std::vector<NoiseKnob>& knobs, const NoisePoint& here, const std::vector<NoisePoint>& around,
                double apart) const;
  void carry(Ascent& ascent, const std::vector<NoiseKnob>& knobs, const NoisePoint& from, const NoisePoint& to) const;
  bool climb_once(const JudgedLog& log, NoiseFound& found, double apart) const;
  double step(const JudgedLog& log, NoiseFound& found, const Ascent& ascent, std::vector<NoisePoint> around) const;
  Eigen::VectorXd prior_slope(const std::vector<NoiseKnob>& knobs, const NoiseModel& model) const;
  double prior(const NoiseModel& model) const;
  void count_run() const;

  Log log_;
  FilterOptions options_, holding_;  // the latter hold the delays
  Start start_;
  NoiseModel centre_;
  WhiteNoiseRange white_;
  bool thorough_;
  std::size_t jobs_;
  Stretches fitted_;
  std::function<void(std::size_t)> ran_;
  mutable std::mutex mutex_;  // of ran_
  mutable std::atomic<std::size_t> runs_{0};
};

/// The logarithms of the values of the knobs.
Eigen::VectorXd logarithms(const std::vector<NoiseKnob>& knobs, NoiseModel model);

/// `model` with the logarithms of its knobs changed by `by`, none beyond its largest value.
NoiseModel moved(const std::vector<NoiseKnob>& knobs, NoiseModel model, const Eigen::VectorXd& by);

/// The observed information about the logarithms of the knobs at `found.best`: minus the second differences of the
/// likelihood of `log` and the prior. That of the search, where they are not positive definite.
Eigen::MatrixXd observed_information(const NoiseSearch& search, const JudgedLog& log, const NoiseFound& found);

/// Where the logarithm of a knob ends, from its value at the top.
struct LogInterval {
  double low, high;

  double reach() const { return (high - low) / 2; }
};

/// The 95 % interval of each knob about `found.best`: where the likelihood of `log` and the prior is less than half of
/// the χ² quantile below the top (Wilks 1938), or at the limit of what is possible. The other knobs are where they
/// are most likely there; at first they go along as `covariance` has it, that of the logarithms by the curvature at the
/// top.
std::vector<LogInterval> likelihood_intervals(const NoiseSearch& search, const JudgedLog& log, const NoiseFound& found,
                                              const Eigen::MatrixXd& covariance);

}  // namespace piste
