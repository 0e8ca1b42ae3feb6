#pragma once
/// Fits a sum of noise processes to an Allan curve by the generalised method of wavelet moments (Guerrier, Skaloud,
/// Stebler and Victoria-Feser 2013, J. American Statistical Association 108), and chooses the model.
///
///     θ = argmin (ν̂ − ν(θ))ᵀ Ω (ν̂ − ν(θ)),      Ω = (V + e² diag ν̂²)⁻¹
///
/// with ν the variances of all scales and V their covariance by the fitted model itself (allan_covariance), by
/// iteration. e is the smallest relative error of every scale with which the best model is not rejected (p above 0.05).
/// It is 0 if a model fits. So a curve that no model describes has wide intervals, and e states the reason.

#include <optional>
#include <string>
#include <vector>

#include "piste/allan/noise_process.h"

namespace piste {

struct GmwmOptions {
  int gauss_markov = 3;       ///< processes at most
  double probability = 0.95;  ///< of intervals and bands
  bool robust = false;        ///< fit the robust variances of the curve
  /// The processes of the model, of which Gauss-Markov may stand several times; empty: it is chosen.
  std::vector<ProcessKind> model = {};
};

/// One process of a fitted model, with the intervals of its numbers.
struct FittedProcess {
  NoiseProcess process;
  double low = 0, high = 0;            ///< of the size
  double low_time = 0, high_time = 0;  ///< of the correlation time
  double sigma_log = 0;                ///< standard deviation of the logarithm of the size
  bool determined = true;              ///< whether the curve determines each number within a factor of three
};

/// A process that the model does not have, and the largest size that would not be detected: 95 %, one-sided.
struct UnseenProcess {
  ProcessKind kind;
  double below = 0;
};

/// A model that was tried.
struct TriedModel {
  std::string name;  ///< such as `white noise + random walk`
  double objective = 0, penalty = 0;
  double criterion() const { return objective + penalty; }
};

struct GmwmFit {
  std::vector<FittedProcess> parts;
  std::vector<UnseenProcess> unseen;
  std::vector<double> variance;   ///< of the model, at the scales of the curve
  std::vector<double> measured;   ///< and those that it was fitted to
  std::vector<double> low, high;  ///< interval of the true variance at each scale, about the estimated one
  Eigen::MatrixXd covariance;     ///< V
  Eigen::MatrixXd logs;           ///< covariance of the logarithms of the numbers, in the order of parts: size, time
  double objective = 0;           ///< of the fit with the covariance V alone: χ² with `freedom` if the model is true
  double freedom = 0, p_value = 1;
  double model_error = 0;           ///< e, of variances
  double worst = 0, worst_tau = 0;  ///< largest relative error of the deviation, beyond its own 2 sigmas, and where
  std::vector<TriedModel> tried;    ///< the best first
  bool fits() const { return p_value > 0.01; }
  std::vector<NoiseProcess> processes() const;
  std::string name() const;  ///< such as `white noise + random walk`
  /// The part of a kind, or null; of several Gauss-Markov the first.
  const FittedProcess* find(ProcessKind kind) const;
};

/// The penalty of each number of a model in the choice: twice that of Akaike, as many models are tried. An absent
/// process is then wrongly included in one of fifty fits, for each kind by itself.
inline constexpr double kPenalty = 4;

/// Fits. A model is chosen by the wavelet information criterion (WVIC: Guerrier and others 2013): the objective, and
/// kPenalty for each number of the model. Only scales with at least four averaged clusters beyond the first two are
/// used. Throws DataError where the curve has fewer than four scales, or does not vary.
GmwmFit fit_gmwm(const AllanCurve& curve, const GmwmOptions& options = {});

}  // namespace piste
