#include "piste/solve/run.h"

#include <algorithm>
#include <utility>

#include "feeder.h"
#include "filter_walk.h"

namespace piste {
namespace {

// A row of what the filter has learned of the noise, if it adapts and a second has passed since the last one.
void note_adapted(const Filter& filter, AdaptedNoise& adapted) {
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
  run.history = History(scratch);
  Filter filter(options, log.world, start, reference);
  const LogPlace place = place_at(log, start.time, part);
  const std::size_t begin = place.imu, end = place.imu_end;
  const bool goes_on = reference && end > begin && reference->last_time() < log.imu[end - 1].time - kSameInstant,
             has_rows = !reference || goes_on;
  run.solution = Solution(filter.layout(), log.world);
  run.solution.sources = filter.sources();
  run.solution.fixed = start.x;
  run.solution.adapted.names = filter.adaptation().names();
  const std::size_t all = end - std::min(begin, end);
  Solution next(filter.layout(), log.world);  // the rows that the sink has not taken yet
  next.fixed = start.x;
  if (has_rows) next.reserve(std::min(all, kRowsAtOnce));
  if (has_rows && !rows) run.solution.reserve(all);
  const auto give_rows = [&] {
    if (next.empty()) return;
    if (rows) {
      rows(next, run.epochs - next.size());
    } else {
      run.solution.append(next.rows());
    }
    next.resize(0);
  };
  const auto take_epoch = [&] {
    Solution& s = run.solution;
    if (has_rows) {
      next.append(filter.time(), filter.estimate(),
                  sigmas_of(log.world, filter.estimate(), filter.layout(), filter.covariance()));
    }
    note_adapted(filter, s.adapted);
    s.innovations.insert(s.innovations.end(), filter.innovations().begin(), filter.innovations().end());
    filter.clear_innovations();
    ++run.epochs;
    if (next.size() == kRowsAtOnce) give_rows();
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
    give_rows();
  };
  if (keep == Keep::kHistory) {
    run.begin = filter;
    run.history.begin(filter.state(), filter.layout(), filter.has_reference());
    FilterWalk recorded(filter, run.history);
    filter_all(recorded);
    run.history.finish(filter.state());
  } else {
    filter_all(filter);
  }
  run.solution.gnss_late = filter.late();
  return run;
}

}  // namespace piste
