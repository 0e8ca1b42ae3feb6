#pragma once
/// The one chain from logs to a trajectory, which every program, study and ensemble runs:
///
///     condition() → with_attitude_sigmas(), with_white_part() → find_start() → run_filter() → smooth_rts()
///
/// Each step is a pure function with a header of its own, for those who want to look or to act between two of them.

#include <cstddef>
#include <functional>
#include <limits>
#include <optional>
#include <string_view>

#include "piste/core/log.h"
#include "piste/core/options.h"
#include "piste/io/replay_config.h"
#include "piste/solve/start.h"

namespace piste {

/// What a replay is told beyond its logs.
struct ReplayOptions {
  ConditioningOptions conditioning = {};
  /// Receivers and reference attitudes in the order of the recording. Of the drift of a reference attitude only the
  /// correlation time is told: its sigma and the white part are taken from the recording.
  FilterOptions filter = {};
  InitialHeading heading = {};                               ///< where the heading at the start comes from
  std::optional<Start> start = std::nullopt;                 ///< where the start is known; else it is looked for
  double longest = std::numeric_limits<double>::infinity();  ///< s after the start, beyond which nothing is filtered
  SmootherKind smoother = SmootherKind::kRts;
  /// Whether checkpoints are kept where nothing is smoothed, so that smooth_rows() can be: some hundred bytes an epoch.
  bool checkpoints = true;
};

/// A replay: what went into the filter, and what came out of it.
struct Replay {
  Log log;                ///< conditioned, with its rests
  FilterOptions options;  ///< that the filter ran with: the errors of the reference attitudes are measured
  FoundStart found;       ///< the start, and a sentence on where it comes from
  FilterRun filtered;     ///< from its checkpoints smooth_rows() can smooth any row with its whole covariance
  std::optional<Solution> smoothed;  ///< where it was asked for; it knows the correlation time of its attitude's errors

  /// The smoothed solution where there is one, else the filtered one.
  const Solution& solution() const { return smoothed ? *smoothed : filtered.solution; }
};

/// Called with a stage, "filter" or "smoother", the epochs that are done and all of them: at 0, then now and then.
using ReplayProgress = std::function<void(std::string_view stage, std::size_t done, std::size_t all)>;

/// What a configuration tells a replay beyond its logs.
ReplayOptions replay_options(const ReplayConfig& config);

/// Reads the logs of the configuration and replays them. Throws as read_recording() and the functions below.
Replay replay(const ReplayConfig& config, const ReplayProgress& progress = {});

/// Conditions the recording and replays it. Throws DataError where the data do not suffice, such as for a start, and
/// ConfigError on options that no filter can run with or that are of other sources than those of the recording.
Replay replay(const Recording& recording, const ReplayOptions& options, const ReplayProgress& progress = {});

/// Replays a log that is conditioned already, with `options.filter` as with_attitude_sigmas() gives it;
/// `options.conditioning` is not used. Throws as above.
Replay replay(Log log, const ReplayOptions& options, const ReplayProgress& progress = {});

}  // namespace piste
