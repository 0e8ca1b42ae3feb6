#include "piste/solve/look_back.h"

#include <algorithm>

#include "piste/solve/rts.h"

namespace piste {

void look_back(const Log& log, const FilterOptions& options, const FoundStart& found, Solution& filtered) {
  if (!found.aligned) return;
  const Solution known =
      smooth_rts(log, run_filter(log, options, found.start, kCheckpointEvery, {}, *found.aligned + kSameInstant));
  for (std::size_t i = 0; i < std::min(known.size(), filtered.size()); ++i) {
    filtered.set(i, known.time(i), known.estimate(i), known.sigmas(i));
  }
}

}  // namespace piste
