#pragma once
/// What a replay came to, as a set of files.

#include <filesystem>
#include <string>

#include "piste/experiment/replay.h"
#include "piste/io/output.h"

namespace piste {

/// Writes `filtered.csv`, `biases.csv`, `innovations.csv`, `smoothed.csv` and `biases_smoothed.csv`, and `attitude.csv`
/// at that rate [Hz], of the smoothed solution where there is one; without it, the smoothed files of an earlier run are
/// withdrawn. Pages, then summary.json, and commit() are the caller's. Throws Error where the disk refuses.
void write_solutions(OutputFolder& output, const Replay& run, double attitude_rate);

/// How the configuration of another replay names `file`, the `attitude.csv` of a smoothed solution, as a reference: a
/// sentence, with the entry to copy.
std::string attitude_entry(const std::filesystem::path& file, const Solution& smoothed);

}  // namespace piste
