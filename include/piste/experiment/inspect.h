#pragma once
/// Inspects logs before anything else runs.

#include <string>
#include <vector>

#include "piste/inspect/inspection.h"
#include "piste/solve/run.h"

namespace piste {

/// Reads files of any kind and finds what looks wrong. Each log is examined by itself, IMUs are compared with
/// receivers, and logs of one kind with one another. If no fault forbids it, the filter runs once over the first
/// minutes with the configuration that the logs suggest, to estimate the lever arm. A file that cannot be read is a
/// suspicion, not an error.
Inspection inspect(const std::vector<std::string>& files, const ProgressCallback& progress = {});

/// Guesses what each file is, without reading its rows, and makes one log of gyroscopes and accelerometers that stand
/// in two files. What is no log, or half of one, has no guess and is listed in `found`.
std::vector<InspectedLog> recognise(const std::vector<std::string>& files, std::vector<Suspicion>& found);

}  // namespace piste
