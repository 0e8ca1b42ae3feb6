#include "piste/solve/relinearise.h"

#include <memory>
#include <utility>

#include "piste/core/time_search.h"
#include "piste/solve/rts.h"

namespace piste {

FilterRun relinearised(const Log& log, const FilterOptions& options, const FoundStart& found, const FilterRun& run,
                       const ProgressCallback& progress) {
  constexpr double kFirstPass = 0.6;  // part of the work
  const Start start = without_alignment(log.world, found);
  Reference smoothed = smoothed_trajectory(run, part_of(progress, 0, kFirstPass));
  const double end = (smoothed.rows.empty() ? start.time : smoothed.rows.back().time) + kSameInstant;
  return run_filter(log, options, start, Keep::kHistory, part_of(progress, kFirstPass, 1), end,
                    std::make_shared<const Reference>(std::move(smoothed)));
}

}  // namespace piste
