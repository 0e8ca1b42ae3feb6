#pragma once
/// What a filtered run says of the time before its heading was known.

#include "piste/solve/run.h"
#include "piste/solve/start.h"

namespace piste {

/// Until the motion has told the heading, a filter knows it as roughly as its start. The rows until `found.aligned` are
/// replaced in its solution by those of a smoother that looks back from there: they use the measurements up to that
/// time, and each of them once. The rows after it stay those of the filter. Does nothing if the heading did not come
/// from the motion.
/// @pre `filtered` is of the same log and start. Throws as run_filter().
void look_back(const Log& log, const FilterOptions& options, const FoundStart& found, FilterRun& filtered);

/// These rows alone: row i takes the place of row i. Empty if the heading did not come from the motion.
Solution looked_back(const Log& log, const FilterOptions& options, const FoundStart& found);

/// Puts the rows of `known` in the place of those of `filtered`, of which the first is row `first` of the run.
void put_rows(const Solution& known, std::size_t first, Solution& filtered);

}  // namespace piste
