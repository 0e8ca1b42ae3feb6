#pragma once
/// The filter over a whole log, and pieces of it once more.

#include <cstddef>
#include <functional>
#include <vector>

#include "piste/solve/filter.h"

namespace piste {

/// Where a walk over a log stands: which sample and which fix of each sensor are next.
struct LogPlace {
  std::size_t imu = 0, imu_end = 0;  ///< next sample, and the end of the samples
  std::vector<std::size_t> fixes;    ///< next fix of each sensor, type by type in the order of the measurement list
};

/// Copies the filter and its place in the log, so that a stretch can be run again.
struct Checkpoint {
  Filter filter;
  LogPlace place;
  std::size_t row = 0;  ///< next row of the solution
};

/// A filtered run, and what a smoother needs to run it again piece by piece.
struct FilterRun {
  Solution solution;
  std::vector<Checkpoint> checkpoints;
};

/// Epochs between checkpoints: a stretch is run again in cache, and the checkpoints cost some hundred bytes an epoch.
inline constexpr int kCheckpointEvery = 128;

/// Called with the fraction done, now and then; may be empty.
using ProgressCallback = std::function<void(double)>;

/// Feeds the log to a Filter from the start's time on: the same bytes as feeding it sample by sample.
/// `checkpoint_every`: epochs between checkpoints, 0 for none. `end_time`: samples from this time on are left out.
/// Throws ConfigError where the options cannot be run with, DataError where the filter diverges.
FilterRun run_filter(const Log& log, const FilterOptions& options, const Start& start, int checkpoint_every = 0,
                     const ProgressCallback& progress = {}, double end_time = 1e300);

/// Runs a stretch again from a checkpoint, recording it: up to and with the epoch of row `end_row` − 1.
void rerun(const Log& log, const Checkpoint& from, std::size_t end_row, Tape& tape);

}  // namespace piste
