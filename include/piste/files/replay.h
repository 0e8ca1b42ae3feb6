#pragma once
/// Writes the files of a replay.

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "piste/experiment/replay.h"
#include "piste/files/output.h"
#include "piste/files/summary.h"
#include "piste/io/solution_io.h"

namespace piste {

/// Writes `filtered.csv`, `biases.csv` and `attitude.csv` as the rows of a run without smoother leave the filter
/// (ReplayOptions::rows), with the bytes of write_solutions().
class RowFiles {
 public:
  RowFiles(OutputFolder& output, const OutputRates& rates) : output_(output), rates_(rates) {}
  /// Takes the next rows.
  void add(const Solution& rows);
  /// Whether rows have come.
  bool begun() const { return means_.count() > 0; }
  /// Of all rows.
  const RowMeans& means() const { return means_; }
  /// Closes the files. Throws Error if one could not be written.
  void finish();

 private:
  void begin(const StateLayout& layout);
  OutputFolder& output_;
  OutputRates rates_;
  RowMeans means_;
  std::vector<OutputFile> files_;
  std::vector<RowCsv> writers_;
};

/// Writes `filtered.csv`, `biases.csv`, `innovations.csv`, `smoothed.csv`, `biases_smoothed.csv`, and `attitude.csv`
/// from the smoothed solution, or else the filtered one; `adapted.csv` if the filter adapts. Without it, or without a
/// smoothed solution, such files of an earlier run are removed. The caller writes pages, then summary.json, and calls
/// commit(). `progress` is told the fraction that is written. `rows`: what has written the files of rows already.
/// Throws Error if a file cannot be written.
void write_solutions(OutputFolder& output, const Replay& run, const OutputRates& rates,
                     const std::function<void(double)>& progress = {}, RowFiles* rows = nullptr);

/// A sentence with the entry by which the configuration of another replay uses `file`, the `attitude.csv` of a smoothed
/// solution, as a reference attitude.
std::string attitude_entry(const std::filesystem::path& file, const Solution& smoothed);

}  // namespace piste
