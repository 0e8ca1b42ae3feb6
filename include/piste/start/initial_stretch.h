#pragma once
/// The initial stretch of a run whose heading came from its motion, and the filter that continues from it.

#include <memory>

#include "piste/filter/run.h"
#include "piste/start/start.h"

namespace piste {

/// The stretch until `FoundStart::aligned`, when the motion had shown the heading. Empty if the heading did not come
/// from the motion.
struct InitialStretch {
  FilterRun run;  ///< from which the rows are smoothed
  /// Its back-smoothed rows: they use the measurements up to its end, and each of them once. Of rests there is a row
  /// every StartOptions::rest_step. Row i is row i of the run.
  Solution rows;
  std::shared_ptr<const Reference> about = nullptr;  ///< the trajectory about which the rows are linearised

  /// How many rows of a filtered solution lie within the stretch.
  std::size_t rows_of(const Solution& filtered) const;
};

/// Filters and smooths the initial stretch, and again about that trajectory until it converges (the iterated Kalman
/// smoother; Bell 1994). Until the motion has shown the heading, a filter knows it only roughly, and a filter that is
/// linearised at a wrong heading estimates wrong lever arms and biases. Throws as run_filter().
InitialStretch initial_stretch(const Log& log, const FilterOptions& options, const FoundStart& found);

/// Filters a run from the start that was found. Within the initial stretch it is linearised about the smoothed
/// trajectory, with an uninformative prior of the attitude, and its rows are those of the stretch. After it, or without
/// one, it is linearised about its own estimate. Arguments and errors as run_filter().
FilterRun filter_from(const InitialStretch& stretch, const Log& log, const FilterOptions& options,
                      const FoundStart& found, Keep keep, const ProgressCallback& progress = {},
                      double end_time = 1e300, const RowTaker& rows = {}, const std::filesystem::path& scratch = {});

/// Replaces the rows of `filtered` up to the end of `known`: by interpolation between its rows, with the sigmas of the
/// later one.
void replace_rows(Solution& filtered, const Solution& known);

}  // namespace piste
