#pragma once
/// Writes the files and pages of inspect, simulate and montecarlo into an output folder. The caller commits.

#include <cstdint>
#include <string>

#include "piste/configuration/replay_config.h"
#include "piste/consistency/consistency.h"
#include "piste/files/output.h"
#include "piste/filter/run.h"
#include "piste/inspect/inspection.h"
#include "piste/sim/simulation.h"
#include "piste/tune/likeliest_noise.h"

namespace piste {

/// `inspection.txt`, `inspection.json` and `inspection.html`; `replay.yaml` and `sensor.yaml`, if the logs suffice for
/// a replay. The replay is run for the first hour, and the configuration takes the causes that its verdict finds
/// (search/rounds.h). If the last verdict is negative, it becomes the first suspicion of `found` and the first comment
/// of `replay.yaml`. Returns the text. `progress` is called with the part of this work that is done.
std::string write_inspection(OutputFolder& output, Inspection& found, const ProgressCallback& progress = {});

/// The logs of a simulated run, `truth.csv` (of further IMUs `truth_NAME.csv`) and `truth.json`, with `prefix`, such as
/// `run_1/`, before their names.
void write_simulation(OutputFolder& output, const std::string& prefix, const Scenario& scenario,
                      const Simulation& simulation, std::uint64_t seed);

/// The page of a tuning, `tune.html`.
std::string tune_page(const ReplayConfig& config, const Tuning& tuning);

/// The files of a tuning (write_tuning()) and its page.
void write_tune(OutputFolder& output, const ReplayConfig& config, const Tuning& tuning);

/// `consistency.json`, `consistency.md` and `consistency.html`. `title`: of the page; `scenario`: its text.
void write_consistency(OutputFolder& output, const ConsistencyReport& report, const std::string& title,
                       const std::string& scenario);

}  // namespace piste
