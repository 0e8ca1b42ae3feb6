#include "piste/solve/run.h"

#include <algorithm>
#include <utility>

#include "piste/core/time_search.h"

namespace piste {
namespace {

// Feeds a log to a filter in the order of time, one IMU sample a call. Fixes up to the time of the sample, and as far
// beyond it as their delays reach, come before it.
class Feeder {
 public:
  Feeder(const Log& log, Checkpoint& c) : log_(log), place_(c.place), filter_(c.filter) {}

  bool done() const { return place_.imu >= place_.imu_end; }

  // Returns true when an epoch was completed.
  bool step() {
    const ImuSample& sample = log_.imu[place_.imu++];
    const double until = sample.time + filter_.look_ahead();
    std::size_t slot = 0;
    MeasurementList::for_each([&]<class Type>() {
      const auto sensors = Type::logged(log_);
      for (std::size_t sensor = 0; sensor < sensors.size(); ++sensor) {
        feed(sensors[sensor], place_.fixes[slot++], until, static_cast<int>(sensor));
      }
    });
    return filter_.add(sample);
  }

 private:
  template <class Fix>
  void feed(const std::vector<Fix>& fixes, std::size_t& next, double until, int sensor) {
    for (; next < fixes.size() && fixes[next].time <= until; ++next) filter_.add(sensor, fixes[next]);
  }

  const Log& log_;
  LogPlace& place_;
  Filter& filter_;
};

template <class Samples>
std::size_t first_from(const Samples& samples, double time) {
  return static_cast<std::size_t>(first_at_or_after(samples, time) - samples.begin());
}

LogPlace place_at(const Log& log, double time, double end_time) {
  LogPlace place{first_from(log.imu, time + kSameInstant), first_from(log.imu, end_time), {}};
  MeasurementList::for_each([&]<class Type>() {
    for (const auto& fixes : Type::logged(log)) place.fixes.push_back(first_from(fixes, time - kSameInstant));
  });
  return place;
}

}  // namespace

FilterRun run_filter(const Log& log, const FilterOptions& options, const Start& start, int checkpoint_every,
                     const ProgressCallback& progress, double end_time) {
  Checkpoint c{Filter(options, log.world, start), place_at(log, start.time, end_time)};
  const std::size_t begin = c.place.imu, end = c.place.imu_end;
  FilterRun run;
  run.solution = Solution(c.filter.layout(), log.world);
  run.solution.sources = c.filter.sources();
  run.solution.fixed = start.x;
  run.solution.reserve(end - std::min(begin, end));
  Feeder feeder(log, c);
  const auto take_epoch = [&] {
    Solution& s = run.solution;
    s.append(c.filter.time(), c.filter.estimate(),
             sigmas_of(c.filter.estimate(), c.filter.layout(), c.filter.covariance()));
    s.innovations.insert(s.innovations.end(), c.filter.innovations().begin(), c.filter.innovations().end());
    c.filter.clear_innovations();
    ++c.row;
  };
  if (checkpoint_every > 0) run.checkpoints.push_back(c);
  while (!feeder.done()) {
    if (!feeder.step()) continue;
    take_epoch();
    if (checkpoint_every > 0 && c.row % static_cast<std::size_t>(checkpoint_every) == 0) run.checkpoints.push_back(c);
    if (progress && c.row % 1000 == 0) progress(static_cast<double>(c.place.imu) / static_cast<double>(end));
  }
  if (c.filter.finish()) take_epoch();
  run.solution.gnss_late = c.filter.late();
  return run;
}

void rerun(const Log& log, const Checkpoint& from, std::size_t end_row, Tape& tape) {
  Checkpoint c = from;
  c.filter.record(&tape);
  Feeder feeder(log, c);
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
