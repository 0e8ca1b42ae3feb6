#include "search/whole_log.h"

#include <utility>

#include "piste/condition/pipeline.h"
#include "piste/core/error.h"
#include "piste/core/state_table.h"
#include "piste/start/start.h"
#include "search/calibration.h"
#include "start/vehicle_mounting.h"
#include "tune/thinned.h"

namespace piste {
namespace {

FilterOptions options_of(const WholeLog& log, const Calibration& found) {
  FilterOptions filter = log.options;
  filter.sensor = found.sensor;
  filter.vehicle = log.vehicle;
  GnssOptions& gnss = filter.gnss.front();
  if (found.tells_arm()) gnss.lever_arm = found.lever_arm;
  gnss.drift = found.drift;
  gnss.velocity_averaging = found.velocity_averaging;
  gnss.use_velocity = gnss.use_velocity && log.velocities;
  filter.estimate = imu_error_blocks(found.sensor);
  filter.estimate.push_back(Block::kLeverArm);
  if (log.find_clock) filter.estimate.push_back(Block::kGnssDelay);
  if (log.drifts) filter.estimate.push_back(Block::kClockDrift);
  if (found.velocity_delay_sigma > 0 && gnss.use_velocity) {
    gnss.velocity_delay = found.velocity_delay;
    filter.estimate.push_back(Block::kVelocityDelay);
  }
  filter.priors = priors_after(found, filter.priors);
  filter.estimate = with_implied_blocks(filter, filter.estimate);
  return filter;
}

}  // namespace

ReplayOptions WholeLog::replayed(const Calibration& found) const {
  ReplayOptions all{.conditioning = conditioning, .filter = options_of(*this, found)};
  all.conditioning.imu.clock_offset = found.clock_offset;
  all.conditioning.imu.clock_drift = found.clock_drift;
  return all;
}

Recording WholeLog::scaled(const Calibration& found) const {
  Recording all = recording;
  scale_sigmas(all.gnss.front().fixes, found.sigma_scales);
  return all;
}

std::optional<Evidence> WholeLog::filtered(const Calibration& found) const {
  try {
    ReplayOptions how = replayed(found);
    const Log log = thinned(condition(scaled(found), how.conditioning));
    how.filter.clock_from = log.imu.front().time;
    Start start = find_start(log, how.filter, how.heading).start;
    const FilterOptions filter = with_mounting(std::move(how.filter), log, start);
    Evidence run = filter_again(log, filter, start, start.time + kLongest);
    if (!run.innovations.empty()) return run;
  } catch (const Error&) {  // no start
  }
  return std::nullopt;
}

}  // namespace piste
