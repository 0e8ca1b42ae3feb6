#pragma once
/// Writes the files and pages of a replay into an output folder. The caller commits.

#include <functional>
#include <string>
#include <vector>

#include "piste/consistency/verdict.h"
#include "piste/files/output.h"
#include "piste/files/replay.h"
#include "piste/files/summary.h"
#include "piste/replay/replay.h"

namespace piste {

/// All that a replay warns of, as terminal, page, summary.json and Python have it: what `inspect` left at the head of
/// the configuration, run_warnings(), a batch that did not converge, and a verdict that is not good.
std::vector<std::string> replay_warnings(const ReplayConfig& config, const Replay& run, const Verdict& verdict);

/// `report.html` of a replay.
std::string replay_page(const ReplayConfig& config, const Replay& run, const Verdict& verdict);

/// All files of a replay (write_solutions()), `trajectory.kml`, `report.html`, and last `summary.json` with the times
/// that `times()` then returns. `progress` gets the fraction that is written. `rows`: as in write_solutions().
void write_replay(OutputFolder& output, const ReplayConfig& config, const Replay& run, const Verdict& verdict,
                  const std::function<RunTimes()>& times, const std::function<void(double)>& progress = {},
                  RowFiles* rows = nullptr);

}  // namespace piste
