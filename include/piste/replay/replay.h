#pragma once
/// The chain from logs to a trajectory, which every program, study and ensemble runs:
///
///     condition() → with_attitude_sigmas(), with_white_part() → find_start() → initial_stretch() →
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
#include "piste/filter/run.h"
#include "piste/start/initial_stretch.h"
#include "piste/start/start.h"

namespace piste {

/// Where the rows of a replay go as it runs, instead of into memory.
struct RowStreams {
  RowTaker filtered;  ///< takes the rows of the filter; without it no row is streamed
  RowTaker smoothed;  ///< takes the rows of the smoother
  /// Folder of unnamed files with the data that the smoother needs again: some kilobytes an epoch. Empty: memory.
  std::filesystem::path scratch;
  /// Of the files for which they are [Hz], 0 being that of the IMU: the rows that stay are among those of this rate.
  double rate = 0;
};

/// Options of a replay.
struct ReplayOptions {
  ConditioningOptions conditioning = {};
  /// Options of the filter, with receivers and reference attitudes in the order of the recording. Of the drift of a
  /// reference attitude only the correlation time is used: its sigma and the white part are computed from the
  /// recording.
  FilterOptions filter = {};
  InitialHeading heading = {};                ///< the source of the initial heading
  std::optional<Start> start = std::nullopt;  ///< a known start; without it, find_start() estimates the start
  double longest = std::numeric_limits<double>::infinity();  ///< s after the start at which the replay ends
  SmootherKind smoother = SmootherKind::kRts;
  BatchSolver batch = {};  ///< the solver of SmootherKind::kBatch: batch_solver() of piste::batch
  /// How often a smoothed run is linearised again about its own smoothed trajectory. One pass is as accurate for scales
  /// as the true rates, and includes an outage of a minute in the sigmas.
  int relinearisations = 1;
  /// Whether to keep the histories of the filtered runs, for smooth_rows().
  bool history = true;
  /// Receivers of rows that need not stay in memory. Not used with a batch.
  RowStreams streams = {};
};
/// As many rows of a solution as a page has. A solution whose rows were streamed keeps no more than these: all, or
/// every n-th row and the last one. It has no history.
inline constexpr std::size_t kKeptRows = 100000;
/// This n for so many rows: 1, or so large that at most half as many remain, to keep the page of a long run small.
constexpr std::size_t rows_apart(std::size_t all) { return all <= kKeptRows ? 1 : 1 + 2 * all / kKeptRows; }

/// The result of a replay: the input of the filter and its output.
struct Replay {
  Log log;                      ///< conditioned, with its stationary intervals
  FilterOptions options;        ///< of the filter, with the measured errors of the reference attitudes
  FoundStart found;             ///< the start, and how it was estimated
  InitialStretch stretch = {};  ///< until `found.aligned`, back-smoothed
  /// The run that the smoother processes, if there is one: filtered about its own smoothed trajectory.
  std::optional<FilterRun> relinearised = std::nullopt;
  FilterRun filtered;                ///< with its history, smooth_rows() gives the whole covariance of any row
  std::optional<Solution> smoothed;  ///< if asked for; with the correlation time of its attitude's errors
  /// Residuals of the smoothed track for judge(), if its rows were streamed; otherwise empty.
  std::vector<double> residuals = {};

  /// The run that a smoother processes.
  const FilterRun& smoothable() const { return relinearised ? *relinearised : filtered; }
  /// The smoothed solution, or the filtered one if there is none.
  const Solution& solution() const { return smoothed ? *smoothed : filtered.solution; }
};

/// Called now and then with the stage ("filter", "relinearising", "smoother" or "batch"), the number of epochs done,
/// and the number of all epochs. The first call of a stage has 0 epochs done.
using ReplayProgress = std::function<void(std::string_view stage, std::size_t done, std::size_t all)>;

/// The options in a configuration.
ReplayOptions replay_options(const ReplayConfig& config);

/// Reads the logs of the configuration and replays them. `batch`: the solver of a run whose configuration asks for a
/// batch. Throws as read_recording() and the functions below.
Replay replay(const ReplayConfig& config, const ReplayProgress& progress = {}, const BatchSolver& batch = {},
              const RowStreams& streams = {});

/// Conditions the recording and replays it. Throws DataError if the data do not suffice, for example for a start.
/// Throws ConfigError if the options are not valid, have other sources than the recording, or ask for a batch without
/// `batch`.
Replay replay(const Recording& recording, const ReplayOptions& options, const ReplayProgress& progress = {});

/// Replays a log that is conditioned already. @pre `options.filter` is the result of with_attitude_sigmas().
/// `options.conditioning` is not used. Throws as above.
Replay replay(Log log, const ReplayOptions& options, const ReplayProgress& progress = {});

}  // namespace piste
