#pragma once
/// The whole log of an IMU and a receiver, replayed as the configuration of an inspection has it.

#include <optional>

#include "core/recording.h"
#include "piste/core/options.h"
#include "piste/inspect/inspection.h"
#include "piste/replay/replay.h"
#include "tune/evidence.h"

namespace piste {

/// A log, and what a replay of it estimates and uses.
struct WholeLog {
  static constexpr double kLongest = 3600;  ///< s of the log: an hour has seen what there is to see

  const Recording& recording;
  const ConditioningOptions& conditioning;
  const FilterOptions& options;           ///< what calibrate() was given, with one receiver
  std::optional<VehicleOptions> vehicle;  ///< what carries the IMU, if it does
  bool find_clock;                        ///< no log states the clock: the delay of the fixes is estimated
  bool drifts = find_clock;               ///< and the drift of the clock
  bool velocities = true;                 ///< those of the receiver are used

  /// Conditioning and filter as the configuration has them with a calibration.
  ReplayOptions replayed(const Calibration& found) const;
  /// The log with the sigmas of positions and velocities that were found.
  Recording scaled(const Calibration& found) const;
  /// A run of the filter over sums of samples (tune/thinned.h); nothing where none runs.
  std::optional<Evidence> filtered(const Calibration& found) const;
};

}  // namespace piste
