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
  RowFiles(OutputFolder& output, const OutputRates& rates, SmootherKind smoother, bool in_thread = true);
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
  void begin(const StateLayout& layout, bool smoothed);
  OutputFolder& output_;
  OutputRates rates_;
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
                     const std::function<void(double)>& progress = {}, RowFiles* rows = nullptr);

/// A sentence with the configuration entry by which another replay uses `file`, the `attitude.csv` of a smoothed
/// solution, as a reference attitude.
std::string attitude_entry(const std::filesystem::path& file, const Solution& smoothed);

}  // namespace piste
