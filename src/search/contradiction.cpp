#include "search/contradiction.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "piste/core/state_table.h"
#include "piste/math/statistics.h"
#include "search/calibration.h"
#include "tune/evidence.h"

namespace piste {
namespace {

constexpr double kRight = 1.2;    // mean NIS of positions that fit
constexpr double kElsewhere = 5;  // sigmas of the run that presumes less: no chance in a thousand logs

// Whether a block ends far from where it ends in a run that presumes less, by the sigmas of that.
bool elsewhere(Block block, const Evidence& with, const Evidence& without) {
  const FullError apart = boxminus(with.last, without.last);
  const auto part = [&](const FullError& e) { return e.segment(full_offset(block), info(block).size).array(); };
  return (part(apart).abs() > kElsewhere * part(without.sigmas)).any();
}

// Whether the slow error of the positions, where one is stated, ends elsewhere: it takes a drift of the track for its
// own, and innovations do not show it. Of the run that presumes more the variance is the smaller, by that of what is
// between both.
bool slow_error_elsewhere(const Calibration& found, const Evidence& with, const Evidence& without) {
  constexpr double kWellKnown = 0.9;  // of the other sigma: what both know as badly is not tested
  if (!found.drift) return false;
  const Block block = position_drift_block(0, found.drift->of_stated);
  const auto part = [&](const FullError& e) { return e.segment(full_offset(block), info(block).size).array(); };
  const Eigen::ArrayXd apart = part(boxminus(with.last, without.last)), more = part(with.sigmas),
                       less = part(without.sigmas);
  return (more < kWellKnown * less && apart.square() > square(kElsewhere) * (less.square() - more.square())).any();
}

}  // namespace

double cost_of_contradiction(const WholeLog& log) {
  constexpr double kRuns = 4, kRunCost = 1.2;  // two each, with and without; a run finds its start besides
  return kRuns * kRunCost * rows_in(log.recording, WholeLog::kLongest);
}

bool drifts_plausibly(const Calibration& found) { return std::abs(found.clock_drift) < kMostClockDrift; }

bool velocities_contradict(WholeLog log, const Calibration& found, const ProgressCallback& progress) {
  const std::vector<GeodeticFix>& fixes = log.recording.gnss.front().fixes;
  const bool some = std::any_of(fixes.begin(), fixes.end(), [](const GeodeticFix& fix) { return fix.velocity; });
  if (!some || !log.options.gnss.front().use_velocity) return false;
  if (!drifts_plausibly(found)) return true;
  log.drifts = found.clock_drift_sigma > 0;
  const auto with = log.filtered(found);
  if (progress) progress(0.5);
  log.velocities = false;
  const auto without = log.filtered(found);
  if (!with || !without) return false;
  // Few positions may lead a filter astray, which proves nothing.
  const auto nis = [](const Evidence& run) { return nis_of_positions(run.innovations, run.sources); };
  if (nis(*without) > std::max(kRight, nis(*with))) return false;
  return elsewhere(Block::kLeverArm, *with, *without) || slow_error_elsewhere(found, *with, *without) ||
         (log.find_clock && elsewhere(Block::kGnssDelay, *with, *without));
}

bool vehicle_contradicts(WholeLog log, const Calibration& found, const ProgressCallback& progress) {
  log.drifts = found.clock_drift_sigma > 0;
  const auto with = log.filtered(found);
  if (progress) progress(0.5);
  log.vehicle.reset();
  const auto without = log.filtered(found);
  if (!with || !without) return false;
  return elsewhere(Block::kGyroScale, *with, *without) || elsewhere(Block::kAccelScale, *with, *without) ||
         slow_error_elsewhere(found, *with, *without);
}

}  // namespace piste
