#pragma once
/// The causes for which the sigmas of a run do not hold. Each cause is tested in turn: the log is filtered again with
/// it. The causes are ranked by the gain of the log-likelihood of the innovations. docs/verdict.md explains it.

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "piste/consistency/verdict.h"
#include "piste/start/start.h"

namespace piste {

/// What a configuration states of the errors of its sensors: a cause is a change of it.
struct StatedModel {
  FilterOptions options;
  std::vector<SigmaScales> scales;           ///< of the sigmas of each receiver, besides those of the log
  double clock_offset = 0, clock_drift = 0;  ///< of the IMU's clock, besides that of the configuration [s], a ratio
};

/// A cause that makes the innovations likelier.
struct LikelierCause {
  double gain;       ///< of the log-likelihood
  std::string text;  ///< as in Verdict::findings
  /// Makes a configuration state it; empty where none of its keys does.
  std::function<void(StatedModel&)> change;
};

/// The verdict on a filtered run with its findings, the most likely cause first. The causes are tested only if the
/// sigmas do not hold or more fixes are rejected than chance rejects, and in the first minutes of motion.
///
/// `options`, `heading` and `found` are those with which `filtered` was made of `log`; `smoothed` may be null, and
/// `residuals` are as for judge().
/// `progress`, if given, is called with the part of the causes that was tried. Causes with which the filter diverges
/// are passed over; nothing is thrown.
Verdict diagnose(const Log& log, const FilterOptions& options, const InitialHeading& heading, const FoundStart& found,
                 const Solution& filtered, const Solution* smoothed, const std::function<void(double)>& progress = {},
                 const std::vector<double>& residuals = {});

/// A verdict, and the causes behind its findings, the most likely first.
struct Diagnosis {
  Verdict verdict;
  std::vector<LikelierCause> causes;
};

/// As diagnose(), with the causes.
Diagnosis diagnosed(const Log& log, const FilterOptions& options, const InitialHeading& heading,
                    const FoundStart& found, const Solution& filtered, const Solution* smoothed,
                    const std::function<void(double)>& progress = {}, const std::vector<double>& residuals = {});

/// Whether the antenna of a receiver moves on the body, as on a helmet: the finding, with the key that states it, where
/// that explains the innovations better than noise, drifts and sigmas would. Nothing where none does. The arguments are
/// those of diagnose(); the sigmas need not fail to hold, as larger ones hide such a motion: `scales` are the factors
/// by which those of each receiver were multiplied in `log`, and it is tried without them, too.
std::optional<std::string> find_sway(const Log& log, const FilterOptions& options, const FoundStart& found,
                                     const std::vector<SigmaScales>& scales = {});

}  // namespace piste
