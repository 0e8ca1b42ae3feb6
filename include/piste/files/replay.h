#pragma once
/// Writes the files of a replay.

#include <filesystem>
#include <functional>
#include <string>

#include "piste/experiment/replay.h"
#include "piste/files/output.h"

namespace piste {

/// Writes `filtered.csv`, `biases.csv`, `innovations.csv`, `smoothed.csv`, `biases_smoothed.csv`, and `attitude.csv`
/// from the smoothed solution, or else the filtered one; `adapted.csv` if the filter adapts. Without it, or without a
/// smoothed solution, such files of an earlier run are removed. The caller writes pages, then summary.json, and calls
/// commit(). `progress` is told the fraction that is written. Throws Error if a file cannot be written.
void write_solutions(OutputFolder& output, const Replay& run, const OutputRates& rates,
                     const std::function<void(double)>& progress = {});

/// A sentence with the entry by which the configuration of another replay uses `file`, the `attitude.csv` of a smoothed
/// solution, as a reference attitude.
std::string attitude_entry(const std::filesystem::path& file, const Solution& smoothed);

}  // namespace piste
