#pragma once
/// Writes the files and the page of runs that are compared into an output folder. The caller commits.

#include "piste/descents/descents.h"
#include "piste/files/output.h"

namespace piste {

/// `gained.csv`, `sections.csv`, `descents.html`, and last `descents.json`.
void write_descents(OutputFolder& output, const DescentReport& report);

}  // namespace piste
