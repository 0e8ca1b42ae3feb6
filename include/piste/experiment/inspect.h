#pragma once
/// Looks logs over before anything else runs.

#include <string>
#include <vector>

#include "piste/inspect/inspection.h"
#include "piste/solve/run.h"

namespace piste {

/// Reads each file, whatever it holds, and finds what looks wrong with it and between them: each log by itself, IMUs
/// against receivers, logs of one kind against one another. Where nothing forbids it the filter runs once over the
/// first minutes, on the configuration that the logs suggest, for the lever arm. What cannot be read is a suspicion,
/// not an error.
Inspection inspect(const std::vector<std::string>& files, const ProgressCallback& progress = {});

}  // namespace piste
