#pragma once
/// How a run begins whose heading came from its motion.

#include <memory>

#include "piste/solve/reference.h"
#include "piste/solve/run.h"
#include "piste/solve/start.h"

namespace piste {

/// What is known of the time until `FoundStart::aligned`, when the motion had told the heading.
struct LookedBack {
  FilterRun run;  ///< from which the rows are smoothed
  /// Its rows, of a smoother that looks back from there: they use the measurements up to that time, and each of them
  /// once. Of rests there is a row every StartOptions::rest_step. Row i is row i of the run. Empty if the heading did
  /// not come from the motion.
  Solution rows;
  /// The trajectory about which they are linearised. Null if the heading did not come from the motion.
  std::shared_ptr<const Reference> about = nullptr;
};

/// Until the motion has told the heading, a filter knows it as roughly as its start, and a filter that is linearised
/// where it believes to be learns something wrong of lever arm and biases. So the time until then is filtered,
/// smoothed, and filtered and smoothed again about what that told, until nothing moves (the iterated Kalman smoother;
/// Bell 1994). Throws as run_filter().
LookedBack looked_back(const Log& log, const FilterOptions& options, const FoundStart& found);

/// Filters a run from the start that was found: about that trajectory, with nothing known of the attitude, until it
/// ends, and freely from there. Where there is none, or the run ends with it, freely from the start. The rows until
/// then have the estimate about which they are linearised, and are to be replaced. Arguments and errors as
/// run_filter().
FilterRun filter_from(const LookedBack& back, const Log& log, const FilterOptions& options, const FoundStart& found,
                      Keep keep, const ProgressCallback& progress = {}, double end_time = 1e300,
                      const RowTaker& rows = {}, const std::filesystem::path& scratch = {});

/// Puts what `known` says in the place of the rows of `filtered` up to its end: on a straight line between its rows,
/// with the sigmas of the later one.
void put_rows(const Solution& known, Solution& filtered);

/// The same for the solution of a run, which keeps its own as `replaced`.
void put_rows(const Solution& known, FilterRun& filtered);

}  // namespace piste
