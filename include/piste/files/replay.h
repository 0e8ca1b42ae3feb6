#pragma once
/// Writes the files of a replay.

#include <array>
#include <filesystem>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "piste/files/output.h"
#include "piste/files/summary.h"
#include "piste/io/solution_io.h"
#include "piste/replay/replay.h"

namespace piste {

class TaskQueue;

/// Writes the files of rows while a replay streams them (ReplayOptions::streams), with the same bytes as
/// write_solutions(): of the filter `filtered.csv` and `biases.csv`, of the smoother `smoothed.csv` and
/// `biases_smoothed.csv`, and `attitude.csv` of the better of both. Another thread makes their text, unless `in_thread`
/// is false.
class RowFiles {
 public:
  /// `extras`: returns the further columns of filtered.csv and smoothed.csv, for a run that has a row of this time.
  RowFiles(OutputFolder& output, const OutputRates& rates, SmootherKind smoother, bool in_thread = true,
           std::function<RowExtras(double time)> extras = {});
  ~RowFiles();
  /// The streams from a replay into these files, which must outlive it, with its scratch in the output folder.
  RowStreams streams();
  /// Whether rows have come.
  bool begun() const { return !solutions_.front().files.empty(); }
  /// The means over all rows of the better solution, after finish().
  const RowMeans& means() const { return means_; }
  /// Closes the files. Throws Error if one could not be written.
  void finish();

 private:
  struct Rows {
    std::vector<OutputFile> files;
    std::vector<RowCsv> writers;
  };
  void add(const Solution& rows, bool smoothed);
  void write(const Solution& rows, bool smoothed);
  void begin(const Solution& rows, bool smoothed);
  OutputFolder& output_;
  OutputRates rates_;
  std::function<RowExtras(double time)> extras_;
  bool smoothed_;
  RowMeans means_;
  std::array<Rows, 2> solutions_;  // filtered and smoothed
  std::unique_ptr<TaskQueue> behind_;
};

/// Writes `filtered.csv`, `biases.csv`, `innovations.csv`, `smoothed.csv`, `biases_smoothed.csv`, and `attitude.csv`
/// from the smoothed solution, or else the filtered one; `adapted.csv` if the filter adapts. Without adaptation or a
/// smoothed solution, such files of an earlier run are removed. The caller writes pages, then summary.json, and calls
/// commit(). `progress` gets the fraction that is written. `rows`: the object that has written the files of rows
/// already. Throws Error if a file cannot be written.
void write_solutions(OutputFolder& output, const Replay& run, const OutputRates& rates,
                     const std::function<void(double)>& progress = {}, RowFiles* rows = nullptr,
                     const RowExtras& extras = {});

/// Writes what the configuration asks for besides: the files of points, whole covariances, and events. Throws DataError
/// if a mark lies outside the run. @pre the run has its histories if config.needs_history()
void write_asked(OutputFolder& output, const Replay& run, const ReplayConfig& config, const RowExtras& extras);

/// The GPS week of the run's times, as its logs state it, or else the configuration. `time`: one of the run.
std::optional<int> gps_week(const ReplayConfig& config, double time);

/// The further columns of the run's rows. Throws DataError if they need a week that is not known.
RowExtras row_extras(const ReplayConfig& config, std::optional<int> week, const Log* log = nullptr);

/// A sentence with the configuration entry by which another replay uses `file`, the `attitude.csv` of a smoothed
/// solution, as a reference attitude.
std::string attitude_entry(const std::filesystem::path& file, const Solution& smoothed);

}  // namespace piste
