#include "piste/solve/relinearise.h"

#include <memory>
#include <utility>

#include "piste/core/time_search.h"
#include "piste/solve/rts.h"

namespace piste {

FilterRun filtered_about(Reference smoothed, const Log& log, const FilterOptions& options, const FoundStart& found,
                         const ProgressCallback& progress) {
  const Start start = without_alignment(log.world, found);
  const double end = (smoothed.rows.empty() ? start.time : smoothed.rows.back().time) + kSameInstant;
  return run_filter(log, options, start, Keep::kHistory, progress, end,
                    std::make_shared<const Reference>(std::move(smoothed)));
}

FilterRun relinearised(const Log& log, const FilterOptions& options, const FoundStart& found, const FilterRun& run,
                       const ProgressCallback& progress) {
  return filtered_about(smoothed_trajectory(run, part_of(progress, 0, kSmoothingFirst)), log, options, found,
                        part_of(progress, kSmoothingFirst, 1));
}

}  // namespace piste
