#pragma once
/// Inspects logs before anything else runs.

#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "piste/inspect/inspection.h"
#include "piste/solve/run.h"

namespace piste {

/// A log to be inspected: a file, or what a file of that name would hold.
struct LogSource {
  std::string file;
  std::optional<std::string_view> content = std::nullopt;  ///< @pre outlives the inspection
};

/// Called now and then with what is being done, in a few words, and how much of the whole work is done, 0 to 1, which
/// does not go back. Where more turns out to be needed, it goes on more slowly.
using StageProgress = std::function<void(std::string_view stage, double done)>;

/// Reads files of any kind and finds what looks wrong. Each log is examined by itself, IMUs are compared with
/// receivers, and logs of one kind with one another. If no fault forbids it, the filter runs once over the first
/// minutes with the configuration that the logs suggest, to estimate the lever arm. A file that cannot be read is a
/// suspicion, not an error.
Inspection inspect(const std::vector<LogSource>& logs, const StageProgress& progress = {});
Inspection inspect(const std::vector<std::string>& files, const StageProgress& progress = {});

/// Guesses what each file is, without reading its rows, and makes one log of gyroscopes and accelerometers that stand
/// in two files. What is no log, or half of one, has no guess and is listed in `found`.
std::vector<InspectedLog> recognise(const std::vector<LogSource>& logs, std::vector<Suspicion>& found);
std::vector<InspectedLog> recognise(const std::vector<std::string>& files, std::vector<Suspicion>& found);

}  // namespace piste
