#pragma once
/// The chain from logs to a trajectory, which every program, study and ensemble runs:
///
///     condition() → with_attitude_sigmas(), with_white_part() → find_start() → looked_back() →
///     filter_from() → relinearised() → smooth_rts(), or run_batch()
///
/// Each step is a pure function with its own header, so that a program can also call them one by one.

#include <cstddef>
#include <filesystem>
#include <functional>
#include <limits>
#include <optional>
#include <string_view>
#include <vector>

#include "piste/batch/batch.h"
#include "piste/configuration/replay_config.h"
#include "piste/core/log.h"
#include "piste/core/options.h"
#include "piste/solve/look_back.h"
#include "piste/solve/run.h"
#include "piste/solve/start.h"

namespace piste {

/// Where the rows of a replay go as it runs, instead of into memory.
struct RowStreams {
  RowTaker filtered;  ///< takes those of the filter; without it no row is streamed
  RowTaker smoothed;  ///< takes those of the smoother
  /// The folder of files without a name, for what the smoother needs again: some kilobytes an epoch. Empty: memory.
  std::filesystem::path scratch;
};

/// Options of a replay.
struct ReplayOptions {
  ConditioningOptions conditioning = {};
  /// Options of the filter, with receivers and reference attitudes in the order of the recording. Of the drift of a
  /// reference attitude only the correlation time is used here: its sigma and the white part are computed from the
  /// recording.
  FilterOptions filter = {};
  InitialHeading heading = {};                               ///< where the heading at the start comes from
  std::optional<Start> start = std::nullopt;                 ///< a known start; without it the start is found
  double longest = std::numeric_limits<double>::infinity();  ///< s after the start at which the replay ends
  SmootherKind smoother = SmootherKind::kRts;
  BatchSolver batch = {};  ///< what smooths with SmootherKind::kBatch: batch_solver() of piste::batch
  /// How often a smoothed run is linearised anew about itself. Once is as good as the true rates for scales, and brings
  /// an outage of a minute into its sigmas.
  int relinearisations = 1;
  /// Whether the histories of the filtered runs are kept, for smooth_rows().
  bool history = true;
  /// Where rows go that need not stand in memory. Not used with a batch.
  RowStreams streams = {};
};
/// Of a solution whose rows were streamed are left the last row and every n-th, so many at most: as many as a page can
/// show, and some. What is left has no history.
inline constexpr std::size_t kKeptRows = 40000;

/// The result of a replay: the input of the filter and its output.
struct Replay {
  Log log;                    ///< conditioned, with its rests
  FilterOptions options;      ///< of the filter, with the measured errors of the reference attitudes
  FoundStart found;           ///< the start, and how it was found
  LookedBack beginning = {};  ///< what is known of the time until `found.aligned`
  /// What the smoother goes back over, if there is one: the run filtered about its own smoothed trajectory.
  std::optional<FilterRun> relinearised = std::nullopt;
  FilterRun filtered;                ///< with its history smooth_rows() can give the whole covariance of any row
  std::optional<Solution> smoothed;  ///< if asked for; with the correlation time of its attitude's errors
  /// Of the smoothed track where its rows were streamed, for judge(); otherwise empty.
  std::vector<double> residuals = {};

  /// The run that a smoother goes back over.
  const FilterRun& smoothable() const { return relinearised ? *relinearised : filtered; }
  /// The smoothed solution, or the filtered one if there is none.
  const Solution& solution() const { return smoothed ? *smoothed : filtered.solution; }
};

/// Called now and then with the stage, "filter", "relinearising", "smoother" or "batch", the number of epochs that are
/// done, and that of all; first with 0 epochs done.
using ReplayProgress = std::function<void(std::string_view stage, std::size_t done, std::size_t all)>;

/// The options in a configuration.
ReplayOptions replay_options(const ReplayConfig& config);

/// Reads the logs of the configuration and replays them. `batch`: what smooths a run whose configuration asks for a
/// batch. Throws as read_recording() and the functions below.
Replay replay(const ReplayConfig& config, const ReplayProgress& progress = {}, const BatchSolver& batch = {},
              const RowStreams& streams = {});

/// Conditions the recording and replays it. Throws DataError if the data do not suffice, for example for a start.
/// Throws ConfigError if the options are not valid, have other sources than the recording, or ask for a batch without
/// `batch`.
Replay replay(const Recording& recording, const ReplayOptions& options, const ReplayProgress& progress = {});

/// Replays a log that is conditioned already. @pre `options.filter` is what with_attitude_sigmas() returns.
/// `options.conditioning` is not used. Throws as above.
Replay replay(Log log, const ReplayOptions& options, const ReplayProgress& progress = {});

}  // namespace piste
