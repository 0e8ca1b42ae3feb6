#include "piste/solve/run.h"

#include <algorithm>
#include <utility>

#include "feeder.h"

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
  Checkpoint c{Filter(options, log.world, start, reference), place_at(log, start.time, part)};
  const std::size_t begin = c.place.imu, end = c.place.imu_end;
  const bool goes_on = reference && end > begin && reference->last_time() < log.imu[end - 1].time - kSameInstant,
             has_rows = !reference || goes_on;
  run.solution = Solution(c.filter.layout(), log.world);
  run.solution.sources = c.filter.sources();
  run.solution.fixed = start.x;
  run.solution.adapted.names = c.filter.adaptation().names();
  const std::size_t all = end - std::min(begin, end);
  if (has_rows) run.solution.reserve(rows ? std::min(all, kRowsAtOnce) : all);
  const auto give_rows = [&](std::size_t least) {
    const std::size_t count = run.solution.size();
    if (!rows || count < std::max<std::size_t>(least, 1)) return;
    rows(run.solution, c.row - count);
    run.solution.resize(0);
  };
  Feeder feeder(log, c.place, c.filter);
  const auto take_epoch = [&] {
    Solution& s = run.solution;
    if (has_rows) {
      s.append(c.filter.time(), c.filter.estimate(),
               sigmas_of(log.world, c.filter.estimate(), c.filter.layout(), c.filter.covariance()));
    }
    note_adapted(c.filter, s.adapted);
    s.innovations.insert(s.innovations.end(), c.filter.innovations().begin(), c.filter.innovations().end());
    c.filter.clear_innovations();
    ++c.row;
    give_rows(kRowsAtOnce);
  };
  if (keep == Keep::kHistory) {
    run.begin = c;
    c.filter.record(&run.history, rows || !has_rows);
  }
  while (!feeder.done()) {
    if (!feeder.step()) continue;
    take_epoch();
    if (progress && c.row % 1000 == 0) progress(static_cast<double>(c.place.imu) / static_cast<double>(end));
  }
  if (c.filter.finish()) take_epoch();
  give_rows(1);
  if (keep == Keep::kHistory) run.history.finish(c.filter.state());
  run.epochs = c.row;
  run.solution.gnss_late = c.filter.late();
  return run;
}

void rerun(const Log& log, const Checkpoint& from, std::size_t end_row, Tape& tape) {
  Checkpoint c = from;
  c.filter.record(&tape);
  Feeder feeder(log, c.place, c.filter);
  while (c.row < end_row) {
    const bool epoch = feeder.done() ? c.filter.finish() : feeder.step();
    if (epoch) {
      c.filter.clear_innovations();
      ++c.row;
    } else if (feeder.done()) {
      break;
    }
  }
}

}  // namespace piste
