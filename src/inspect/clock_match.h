#pragma once
/// Estimates the offset of an IMU's clock from the motion, independently of its axes and units: see
/// inspect/log_match.h.

#include <optional>

#include "log_signals.h"
#include "piste/inspect/log_match.h"

namespace piste {

/// The offset, or nullopt if the motion does not determine it or fits several offsets. It may be uncertain. It always
/// is if the search is limited to `within`, because then no correlation is too small.
std::optional<ClockMatch> match_clocks(const ImuIntegral& imu, const Track& track,
                                       const std::optional<Interval>& within = {});

/// 1-sigma of a matched offset [s]: that of the match, and what it leaves out. A body turns somewhat before or after
/// its track, and the track between two fixes is unknown. Over simulated runs with skis and bicycles the offset was
/// wrong by 0.012 s with ten fixes a second, by 0.03 to 0.06 s with one.
double clock_sigma(double of_match, const GnssHealth& health);

/// Turn rate of the gyroscopes divided by that of the track, with the IMU's clock `offset` ahead. 0 if the turns do not
/// determine it.
double turn_ratio(const ImuIntegral& imu, const Track& track, double offset);

/// Correlation of the gyroscopes' rate about down, by the mean force, with the turn rate of the track. Negative if the
/// track turns the other way round. 0 if that rate does not explain most of the turns.
double turn_correlation(const ImuIntegral& imu, const Track& track, double offset);

}  // namespace piste
