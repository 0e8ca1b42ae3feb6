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

}  // namespace piste
