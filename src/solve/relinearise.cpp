#include "piste/solve/relinearise.h"

#include <memory>
#include <numbers>
#include <utility>

#include "piste/core/time_search.h"
#include "piste/solve/rts.h"
#include "start_place.h"

namespace piste {

FilterRun relinearised(const Log& log, const FilterOptions& options, const FoundStart& found, const FilterRun& run,
                       const ProgressCallback& progress) {
  constexpr double kTilt = 0.5, kAnyHeading = std::numbers::pi / std::numbers::sqrt3;  // rad: nothing is known
  constexpr double kFirstPass = 0.6;                                                   // part of the work
  const auto part = [&](double from, double to) -> ProgressCallback {
    if (!progress) return {};
    return [&progress, from, to](double done) { progress(from + done * (to - from)); };
  };
  Start start = found.start;
  if (found.aligned) set_attitude_sigma(log.world, start, {kTilt, kTilt, kAnyHeading});
  Reference smoothed = smoothed_trajectory(log, run, part(0, kFirstPass));
  const double end = (smoothed.rows.empty() ? start.time : smoothed.rows.back().time) + kSameInstant;
  return run_filter(log, options, start, kCheckpointEvery, part(kFirstPass, 1), end,
                    std::make_shared<const Reference>(std::move(smoothed)));
}

}  // namespace piste
