#include "piste/solve/look_back.h"

#include <algorithm>

#include "piste/solve/relinearise.h"
#include "piste/solve/rts.h"

namespace piste {

Solution looked_back(const Log& log, const FilterOptions& options, const FoundStart& found) {
  if (!found.aligned) return {};
  const FilterRun run = run_filter(log, options, found.start, Keep::kHistory, {}, *found.aligned + kSameInstant);
  return smooth_rts(relinearised(log, options, found, run));
}

void put_rows(const Solution& known, std::size_t first, Solution& filtered) {
  for (std::size_t i = first; i < std::min(known.size(), first + filtered.size()); ++i) {
    filtered.set(i - first, known.time(i), known.estimate(i), known.sigmas(i));
  }
}

void look_back(const Log& log, const FilterOptions& options, const FoundStart& found, FilterRun& filtered) {
  put_rows(looked_back(log, options, found), 0, filtered.solution);
}

}  // namespace piste
