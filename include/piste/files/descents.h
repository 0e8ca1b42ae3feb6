#pragma once
/// The files of runs that are compared.

#include <string>

#include "piste/descents/descents.h"

namespace piste {

/// `descents.json`: the runs, the line, and for each gate its distance along the line and of each run `time_s`,
/// `sigma_time_s`, `offset_m` (right positive), `gained_s`, `sigma_gained_s`; null where unknown.
std::string descents_json(const DescentReport& report);

/// `gained.csv`: along the line, for each run time, offset, speed, specific energy, radius and load; for each but the
/// first the time gained and its sigma. Empty where unknown.
std::string gained_csv(const DescentReport& report);

/// `sections.csv`: from gate to gate.
std::string sections_csv(const DescentReport& report);

}  // namespace piste
