#pragma once
/// One Gauss-Newton step for a whole run: it is filtered again about its own smoothed trajectory (reference.h).

#include "filter/reference.h"
#include "piste/filter/run.h"

namespace piste {

/// Fraction of the work of relinearised() that smoothing takes, before the run is filtered again.
inline constexpr double kSmoothingFirst = 0.2;

/// Filters the log of `run` again, about the smoothed trajectory of `run`. A smoother of the result has no
/// linearisation errors of a filter that drifted through an outage, and its scales do not follow the noise. `start` is
/// without_alignment(), as the motion that determined the attitude is filtered here, too. `options` are those of `run`.
/// @pre `run` has its history. Throws as run_filter().
FilterRun relinearised(const Log& log, const FilterOptions& options, const Start& start, const FilterRun& run,
                       const ProgressCallback& progress = {});

/// The second half of relinearised(). `smoothed` is the smoothed_trajectory() of a run, which need not exist any more.
FilterRun filtered_about(Reference smoothed, const Log& log, const FilterOptions& options, const Start& start,
                         const ProgressCallback& progress = {});

}  // namespace piste
