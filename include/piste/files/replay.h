#pragma once
/// Writes the files of a replay.

#include <filesystem>
#include <string>

#include "piste/experiment/replay.h"
#include "piste/files/output.h"

namespace piste {

/// Writes `filtered.csv`, `biases.csv`, `innovations.csv`, `smoothed.csv`, `biases_smoothed.csv`, and `attitude.csv` at
/// the rate `attitude_rate` [Hz] from the smoothed solution, or else the filtered one; `adapted.csv` if the filter
/// adapts. Without it, or without a smoothed solution, such files of an earlier run are removed. The caller writes
/// pages, then summary.json, and calls commit(). Throws Error if a file cannot be written.
void write_solutions(OutputFolder& output, const Replay& run, double attitude_rate);

/// A sentence with the entry by which the configuration of another replay uses `file`, the `attitude.csv` of a smoothed
/// solution, as a reference attitude.
std::string attitude_entry(const std::filesystem::path& file, const Solution& smoothed);

}  // namespace piste
