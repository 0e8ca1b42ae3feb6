#pragma once
/// Looks logs over before anything else runs.

#include <functional>
#include <string>
#include <vector>

#include "piste/analyse/inspection.h"

namespace piste {

/// Reads each file, whatever it holds, and finds what looks wrong with it and between them: each log by itself, IMUs
/// against receivers, logs of one kind against one another. Where nothing forbids it the filter runs once over the
/// first minutes, on the configuration that the logs suggest, for the lever arm. `stage` is called with what is done
/// next and the part of all that is done; it may be empty. What cannot be read is a suspicion, not an error.
Inspection inspect(const std::vector<std::string>& files,
                   const std::function<void(const std::string&, double)>& stage = {});

}  // namespace piste
