#include "piste/solve/look_back.h"

#include <algorithm>

#include "piste/solve/relinearise.h"
#include "piste/solve/rts.h"

namespace piste {

void look_back(const Log& log, const FilterOptions& options, const FoundStart& found, Solution& filtered) {
  if (!found.aligned) return;
  const FilterRun run = run_filter(log, options, found.start, kCheckpointEvery, {}, *found.aligned + kSameInstant);
  const Solution known = smooth_rts(log, relinearised(log, options, found, run));
  for (std::size_t i = 0; i < std::min(known.size(), filtered.size()); ++i) {
    filtered.set(i, known.time(i), known.estimate(i), known.sigmas(i));
  }
}

}  // namespace piste
