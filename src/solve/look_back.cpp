#include "piste/solve/look_back.h"

#include <algorithm>

#include "piste/solve/fix_queue.h"
#include "piste/solve/rts.h"

namespace piste {

LookedBack looked_back(const Log& log, const FilterOptions& options, const FoundStart& found) {
  if (!found.aligned) return {};
  const double end = *found.aligned + kSameInstant;
  const FilterRun run = run_filter(log, options, found.start, Keep::kHistory, {}, end);
  LookedBack back;
  back.about = std::make_shared<const Reference>(smoothed_trajectory(run));
  back.run = run_filter(log, options, without_alignment(log.world, found), Keep::kHistory, {}, end, back.about);
  back.rows = smooth_rts(back.run);
  return back;
}

FilterRun filter_from(const LookedBack& back, const Log& log, const FilterOptions& options, const FoundStart& found,
                      Keep keep, const ProgressCallback& progress, double end_time, const RowTaker& rows,
                      const std::filesystem::path& scratch) {
  const double end = std::min(end_time, log.imu.empty() ? 0 : log.imu.back().time);
  const bool goes_on = back.about && back.about->size() > 0 && back.about->last_time() < end - kSameInstant;
  return goes_on ? run_filter(log, options, without_alignment(log.world, found), keep, progress, end_time, back.about,
                              rows, scratch)
                 : run_filter(log, options, found.start, keep, progress, end_time, nullptr, rows, scratch);
}

void put_rows(const Solution& known, std::size_t first, Solution& filtered) {
  for (std::size_t i = first; i < std::min(known.size(), first + filtered.size()); ++i) {
    filtered.set(i - first, known.time(i), known.estimate(i), known.sigmas(i));
  }
}

void put_rows(const Solution& known, FilterRun& filtered) {
  Solution& rows = filtered.solution;
  filtered.replaced = Solution(rows.layout(), rows.world());
  filtered.replaced.fixed = rows.fixed;
  filtered.replaced.append(rows.rows().first(std::min(known.size(), rows.size()) * rows.stride()));
  put_rows(known, 0, rows);
}

}  // namespace piste
