#pragma once
/// Runs the filter over a whole log.

#include <cstddef>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <vector>

#include "piste/filter/filter.h"

namespace piste {

class History;    // src/filter/history.h
class Reference;  // src/filter/reference.h

/// The part of a log that a filter uses.
struct LogPart {
  double end = 1e300;  ///< samples from this time on are left out
  /// Samples at standstill are merged, up to this duration [s]: fewer samples are as informative there. 0: no merging.
  double rest_step = 0;
};

/// What a run stores besides its solution.
enum class Keep {
  kNothing,
  kHistory,      ///< what a smoother needs: some 400 bytes per epoch, and a kilobyte per fix
  kWholeHistory  ///< the same with the estimates at all epochs, so that the rows of the solution may change
};

/// A filtered run, and what a smoother needs of it.
struct FilterRun {
  Solution solution;
  std::size_t epochs = 0;  ///< IMU epochs that were filtered: the rows of the solution, unless about a reference
  /// Record of the run for a smoother; null if it is not kept. Rows that the solution holds unchanged are stored once.
  std::shared_ptr<const History> history = nullptr;
};

/// Called from time to time with the completed fraction of the work. May be empty.
using ProgressCallback = std::function<void(double)>;

/// A callback for a part of the work, from one fraction of the whole to another. Empty if `whole` is empty. `whole`
/// must outlive it.
inline ProgressCallback part_of(const ProgressCallback& whole, double from, double to) {
  if (!whole) return {};
  return [&whole, from, to](double done) { whole(from + done * (to - from)); };
}

/// Takes the rows of a run while it proceeds: `kRowsAtOnce` at a time, and fewer at the end. `first`: index of the
/// first of them in the run. The rows may be changed, and are discarded afterwards.
using RowTaker = std::function<void(Solution& rows, std::size_t first)>;
inline constexpr std::size_t kRowsAtOnce = 1024;  // some hundred kilobytes

/// Filters a log from the time of `start` on. The result has the same bytes as that of a Filter that is fed sample by
/// sample.
/// `part`: the samples of the log to use.
/// `reference`: a smoothed run of the same log about which this run is linearised while it lasts
/// (src/filter/reference.h). If it lasts to the end, the solution has no rows: only a smoother improves on it.
/// `rows`: takes the rows of the solution, which is empty in the end.
/// `scratch`: folder of the file that holds the history; empty: memory.
/// Throws ConfigError if the options are not valid, DataError if the filter diverges.
FilterRun run_filter(const Log& log, const FilterOptions& options, const Start& start, Keep keep = Keep::kNothing,
                     const ProgressCallback& progress = {}, const LogPart& part = {},
                     const std::shared_ptr<const Reference>& reference = nullptr, const RowTaker& rows = {},
                     const std::filesystem::path& scratch = {});

}  // namespace piste
