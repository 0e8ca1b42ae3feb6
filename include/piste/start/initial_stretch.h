#pragma once
/// The initial stretch of a run whose heading was found from the motion, and the filter that continues from it.

#include <memory>

#include "piste/filter/run.h"
#include "piste/start/start.h"

namespace piste {

/// The stretch until `FoundStart::aligned`, by which the motion has determined the heading. Empty if the heading was
/// not found from the motion.
struct InitialStretch {
  FilterRun run;  ///< the filtered run that is smoothed to `rows`
  /// Its back-smoothed rows: each measurement up to its end is used, and used once. At standstill there is one row per
  /// StartOptions::rest_step. Row i is row i of the run.
  Solution rows;
  std::shared_ptr<const Reference> about = nullptr;  ///< the trajectory about which the rows are linearised

  /// Number of rows of a filtered solution that lie within the stretch.
  std::size_t rows_of(const Solution& filtered) const;
};

/// Filters and smooths the initial stretch, and repeats this about the smoothed trajectory until it converges (the
/// iterated Kalman smoother; Bell 1994). A filter knows the heading only roughly until the motion has determined it. A
/// filter that is linearised at a wrong heading estimates wrong lever arms and biases. Throws as run_filter().
InitialStretch initial_stretch(const Log& log, const FilterOptions& options, const FoundStart& found);

/// Filters a run from the start that was found. Within the initial stretch it is linearised about the smoothed
/// trajectory, with an uninformative prior of the attitude. There its rows are those of the stretch. After the stretch,
/// or without one, it is linearised about its own estimate. Arguments and errors as run_filter().
FilterRun filter_from(const InitialStretch& stretch, const Log& log, const FilterOptions& options,
                      const FoundStart& found, Keep keep, const ProgressCallback& progress = {},
                      double end_time = 1e300, const RowTaker& rows = {}, const std::filesystem::path& scratch = {});

/// Replaces the rows of `filtered` up to the end of `known`. The estimates are interpolated between the rows of
/// `known`; the sigmas are those of the later row.
void replace_rows(Solution& filtered, const Solution& known);

}  // namespace piste
