#pragma once
/// One Gauss-Newton step for a whole run: filtered again about its own smoothed trajectory (reference.h).

#include "filter/reference.h"
#include "piste/filter/run.h"

namespace piste {

/// Of the work of relinearised(), the part that smoothing takes before the run is filtered again.
inline constexpr double kSmoothingFirst = 0.2;

/// Filters the log of `run` about what a smoother makes of `run`. What is smoothed from the result has neither the
/// linearisation errors of a filter that drifted through an outage, nor scales that follow the noise. `start` is
/// without_alignment(), as the motion that showed the attitude is filtered here, too. `options` are those of `run`.
/// @pre `run` has its history. Throws as run_filter.
FilterRun relinearised(const Log& log, const FilterOptions& options, const Start& start, const FilterRun& run,
                       const ProgressCallback& progress = {});

/// Its second half: `smoothed` is what smoothed_trajectory() makes of a run, which need not be there any more.
FilterRun filtered_about(Reference smoothed, const Log& log, const FilterOptions& options, const Start& start,
                         const ProgressCallback& progress = {});

}  // namespace piste
