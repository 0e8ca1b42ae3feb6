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

/// What of a log a filter takes.
struct LogPart {
  double end = 1e300;  ///< samples from this time on are left out
  /// Samples of a rest are taken together, up to so long [s]: a body that stands tells as much by fewer. 0: one by one.
  double rest_step = 0;
};

/// What a run keeps beside its solution.
enum class Keep {
  kNothing,
  kHistory,      ///< what a smoother needs: some 400 bytes an epoch, and a kilobyte a fix
  kWholeHistory  ///< the same with the estimates at all epochs, so that the rows of the solution may be changed
};

/// A filtered run, and what a smoother needs of it.
struct FilterRun {
  Solution solution;
  std::size_t epochs = 0;  ///< IMU epochs that were filtered: the rows of the solution, unless about a reference
  /// All that the filter did, for a smoother; null if it is not kept. Without rows that it can take from the solution.
  std::shared_ptr<const History> history = nullptr;
};

/// Called now and then with the fraction of the work that is done. May be empty.
using ProgressCallback = std::function<void(double)>;

/// A callback for a part of the work, from one fraction of the whole to another. Empty if `whole` is, which must
/// outlive it.
inline ProgressCallback part_of(const ProgressCallback& whole, double from, double to) {
  if (!whole) return {};
  return [&whole, from, to](double done) { whole(from + done * (to - from)); };
}

/// Takes the rows of a run as it goes, `kRowsAtOnce` at a time and fewer at the end. `first`: which row of the run the
/// first of them is. They may be changed, and are gone afterwards.
using RowTaker = std::function<void(Solution& rows, std::size_t first)>;
inline constexpr std::size_t kRowsAtOnce = 1024;  // some hundred kilobytes

/// Filters a log, from the time of `start` on. The result has the same bytes as that of a Filter that is fed sample by
/// sample.
/// `part`: of the log, which samples.
/// `reference`: a smoothed run of the same log about which this one is linearised (src/filter/reference.h), as far as
/// it goes. If it goes to the end, the solution has no rows, as only a smoother tells what is better than the
/// reference. `rows`: takes the rows of the solution, which then has none in the end. `scratch`: the folder of a file
/// that has the history, which otherwise is in memory. Throws ConfigError if the options are not valid, DataError if
/// the filter diverges.
FilterRun run_filter(const Log& log, const FilterOptions& options, const Start& start, Keep keep = Keep::kNothing,
                     const ProgressCallback& progress = {}, const LogPart& part = {},
                     const std::shared_ptr<const Reference>& reference = nullptr, const RowTaker& rows = {},
                     const std::filesystem::path& scratch = {});

}  // namespace piste
