#include "smoother/relinearise.h"

#include <memory>
#include <utility>

#include "core/time_search.h"
#include "filter/reference.h"
#include "piste/smoother/rts.h"

namespace piste {

FilterRun filtered_about(Reference smoothed, const Log& log, const FilterOptions& options, const Start& start,
                         const ProgressCallback& progress) {
  const double end = (smoothed.size() == 0 ? start.time : smoothed.last_time()) + kSameInstant;
  const std::filesystem::path scratch = smoothed.scratch();
  return run_filter(log, options, start, Keep::kHistory, progress, {.end = end},
                    std::make_shared<const Reference>(std::move(smoothed)), {}, scratch);
}

FilterRun relinearised(const Log& log, const FilterOptions& options, const Start& start, const FilterRun& run,
                       const ProgressCallback& progress) {
  return filtered_about(smoothed_trajectory(run, part_of(progress, 0, kSmoothingFirst)), log, options, start,
                        part_of(progress, kSmoothingFirst, 1));
}

}  // namespace piste
