#pragma once
/// What inspect, simulate and montecarlo write: the files and pages of each in its folder. The caller commits.

#include <cstdint>
#include <string>

#include "piste/consistency/consistency.h"
#include "piste/files/output.h"
#include "piste/inspect/inspection.h"
#include "piste/sim/simulation.h"

namespace piste {

/// `inspection.txt` and `inspection.html`; `replay.yaml` and `sensor.yaml`, if the logs suffice for a replay. That is
/// run (the first hour): where its verdict does not hold, it is added to the suspicions of `found` as the first of
/// them, and is the first comment of `replay.yaml`. Returns the text.
std::string write_inspection(OutputFolder& output, Inspection& found);

/// The logs of a simulated run, `truth.csv` (of further IMUs `truth_NAME.csv`) and `truth.json`, with `prefix`, such as
/// `run_1/`, before their names.
void write_simulation(OutputFolder& output, const std::string& prefix, const Scenario& scenario,
                      const Simulation& simulation, std::uint64_t seed);

/// `consistency.json`, `consistency.md` and `consistency.html`. `title`: of the page; `scenario`: its text.
void write_consistency(OutputFolder& output, const ConsistencyReport& report, const std::string& title,
                       const std::string& scenario);

}  // namespace piste
