#pragma once
/// Reads a log, and examines it by itself.

#include <vector>

#include "piste/inspect/inspection.h"

namespace piste {

/// Fills in the rows of `log` and their health, according to its guess. Faults go to `found`. A log that cannot be read
/// as guessed loses its guess.
void examine(InspectedLog& log, std::vector<Suspicion>& found);

/// Takes out of the rests of the first IMU the times in which the first receiver says that it moves, if their clocks
/// are known to each other, and examines it again.
void judge_rests(Inspection& inspection);

/// Takes out of the times of the first IMU the steps forward of its clock, which the fixes of the first receiver show
/// from missing rows (inspect/clock_leaps.h), and lists them.
void take_out_leaps(Inspection& inspection);

}  // namespace piste
