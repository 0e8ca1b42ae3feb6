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
  const Solution known = looked_back(log, options, found);
  Solution& rows = filtered.solution;
  filtered.replaced = Solution(rows.layout(), rows.world());
  filtered.replaced.fixed = rows.fixed;
  filtered.replaced.append(rows.rows().first(std::min(known.size(), rows.size()) * rows.stride()));
  put_rows(known, 0, rows);
}

}  // namespace piste
