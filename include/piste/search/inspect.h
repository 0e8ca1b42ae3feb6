#pragma once
/// Inspects logs before anything else runs.

#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "piste/filter/run.h"
#include "piste/inspect/inspection.h"

namespace piste {

/// A log to be inspected: a file, or the content of a file with that name.
struct LogSource {
  std::string file;
  std::optional<std::string_view> content = std::nullopt;  ///< @pre outlives the inspection
};

/// Called now and then with the current stage in a few words, and the part of the whole work that is done, 0 to 1. It
/// does not go back. If more work turns out to be needed, it grows more slowly.
using StageProgress = std::function<void(std::string_view stage, double done)>;

/// Reads files of any kind and lists their faults. Each log is examined alone, IMUs are compared with receivers, and
/// logs of one kind with one another. If no fault forbids it, the filter runs with the configuration that the logs
/// suggest, to estimate the lever arm, clock offset and noise. A file that cannot be read is a suspicion, not an error.
Inspection inspect(const std::vector<LogSource>& logs, const StageProgress& progress = {});
Inspection inspect(const std::vector<std::string>& files, const StageProgress& progress = {});

/// Guesses the format of each file without reading its rows. Joins gyroscopes and accelerometers in two files into one
/// log. A file that is no log, or half of one, has no guess and is listed in `found`.
std::vector<InspectedLog> recognise(const std::vector<LogSource>& logs, std::vector<Suspicion>& found);
std::vector<InspectedLog> recognise(const std::vector<std::string>& files, std::vector<Suspicion>& found);

}  // namespace piste
