#pragma once
/// The search for the likeliest noise of a conditioned log with a known start.

#include <Eigen/Core>
#include <atomic>
#include <cstddef>
#include <functional>
#include <string>
#include <vector>

#include "experiment/noise_model.h"
#include "piste/core/solution.h"
#include "piste/solve/initial_state.h"

namespace piste {

/// A noise, and the run with it.
struct NoisePoint {
  NoiseModel model;
  std::vector<Innovation> innovations;  ///< those that tell (experiment/innovation_likelihood.h)
  std::vector<std::string> sources;     ///< names, by Innovation::source
  double likelihood = 0;                ///< of them; −∞ where the filter diverges
  double value = 0;                     ///< with the prior
};

/// What a search found.
struct NoiseFound {
  NoisePoint best;
  std::vector<NoiseKnob> knobs;
  Eigen::MatrixXd covariance;  ///< of the logarithms of their values
  double likelihood_at_start = 0;
};

/// Filters a log again and again with other noise. The log and its start stay as they are.
///
/// What a run rejects changes by leaps. So each step begins with a run that judges: fixes that it rejects count as
/// spoilt, with sigmas five times as large (the wide part of a contaminated normal distribution), one in fifty at most,
/// and all runs around it use all fixes.
class NoiseSearch {
 public:
  /// The values of `centre` are those about which the prior is. `jobs` runs at a time; the result does not depend on it.
  NoiseSearch(const Log& log, const FilterOptions& options, const Start& start, const NoiseModel& centre,
              std::size_t jobs);

  /// The likeliest noise near `from`, by Gauss and Newton in the logarithms: the gradient is a difference of the
  /// likelihood, and the curvature the information of Gaussian innovations z with sigmas σ,
  /// Σ (∂z ∂zᵀ/σ² + 2 ∂ln σ ∂ln σᵀ) over their rows, from the same runs (as in the method of scoring; Gupta and Mehra
  /// 1974). S counts in it as if it were diagonal. Throws DataError if the filter runs with no noise that is tried.
  NoiseFound climb(const NoiseModel& from, const std::function<void(double)>& progress = {}) const;

  /// The likeliest of several models, as they are, with the fixes as `judge` finds them.
  NoisePoint likeliest(const NoiseModel& judge, const std::vector<NoiseModel>& models) const;

  /// The innovations of one run, and their sources; nothing else of a solution. `gated`: with the gate of the options.
  Solution run(const Log& log, const NoiseModel& model, bool gated) const;

  /// Number of filter runs so far.
  std::size_t runs() const { return runs_; }

 private:
  struct Ascent {
    Eigen::VectorXd slope;
    Eigen::MatrixXd information;
  };
  Ascent ascent(const std::vector<NoiseKnob>& knobs, const std::vector<NoisePoint>& points, double apart) const;
  Log judged(const NoiseModel& model) const;
  NoisePoint filtered(const Log& log, const NoiseModel& model) const;
  double prior(const NoiseModel& model) const;

  const Log& log_;
  FilterOptions options_;
  Start start_;
  NoiseModel centre_;
  std::size_t jobs_;
  mutable std::atomic<std::size_t> runs_ = 0;
};

}  // namespace piste
