#include "piste/filter/run.h"

#include <algorithm>
#include <utility>

#include "core/time_search.h"
#include "filter/feeder.h"
#include "filter/filter_walk.h"
#include "filter/history.h"
#include "filter/reference.h"

namespace piste {
namespace {

constexpr double kForever = 1e300;  // s

// Appends a row of the estimated noise factors, if the filter adapts and a second has passed since the last row.
void note_adapted(const KalmanFilter& filter, AdaptedNoise& adapted) {
  constexpr double kEvery = 1;  // s
  if (adapted.names.empty() || (!adapted.time.empty() && filter.time() < adapted.time.back() + kEvery)) return;
  adapted.time.push_back(filter.time());
  filter.adaptation().append_to(adapted.factors);
}

}  // namespace

FilterRun run_filter(const Log& log, const FilterOptions& options, const Start& start, Keep keep,
                     const ProgressCallback& progress, const LogPart& part,
                     const std::shared_ptr<const Reference>& reference, const RowTaker& rows,
                     const std::filesystem::path& scratch) {
  FilterRun run;
  KalmanFilter filter(options, log.world, start, reference);
  const LogPlace place = place_at(log, start.time, part);
  const std::size_t begin = place.imu, end = place.imu_end;
  const bool goes_on = reference && end > begin && reference->last_time() < log.imu[end - 1].time - kSameInstant,
             has_rows = !reference || goes_on;
  run.solution = Solution(StateLayout(options.estimate), log.world);
  run.solution.sources = filter.sources();
  run.solution.fixed = start.x;
  run.solution.adapted.names = filter.adaptation().names();
  const std::size_t all = end - std::min(begin, end);
  if (has_rows) run.solution.reserve(rows ? std::min(all, kRowsAtOnce) : all);
  const auto give_rows = [&](std::size_t least) {
    const std::size_t count = run.solution.size();
    if (!rows || count < std::max<std::size_t>(least, 1)) return;
    rows(run.solution, run.epochs - count);
    run.solution.resize(0);
  };
  const auto take_epoch = [&] {
    Solution& s = run.solution;
    if (has_rows) {
      s.append(filter.time(), filter.estimate(),
               sigmas_of(log.world, filter.estimate(), filter.layout(), filter.covariance()));
    }
    note_adapted(filter, s.adapted);
    s.innovations.insert(s.innovations.end(), filter.innovations().begin(), filter.innovations().end());
    filter.clear_innovations();
    ++run.epochs;
    give_rows(kRowsAtOnce);
  };
  const auto filter_all = [&](auto& walk) {
    Feeder feeder(log, place, walk);
    while (!feeder.done()) {
      if (!feeder.step()) continue;
      take_epoch();
      if (progress && run.epochs % 1000 == 0) {
        progress(static_cast<double>(feeder.place().imu) / static_cast<double>(end));
      }
    }
    if (walk.finish()) take_epoch();
    give_rows(1);
  };
  if (keep != Keep::kNothing) {
    auto history = std::make_shared<History>(scratch);
    // The rows of the initial stretch, which is about a reference, are replaced (start/initial_stretch.h).
    const bool all_own = rows || !has_rows || keep == Keep::kWholeHistory;
    const double about_until = reference ? reference->last_time() : -kForever;
    history->begin(filter, all_own ? kForever : about_until);
    FilterWalk recorded(filter, *history);
    filter_all(recorded);
    history->finish(filter.state());
    run.history = std::move(history);
  } else {
    filter_all(filter);
  }
  run.solution.gnss_late = filter.late();
  return run;
}

}  // namespace piste
