#pragma once
/// Whether what the first minutes of motion told holds over the whole log.

#include <cstddef>
#include <optional>

#include "piste/core/options.h"
#include "piste/core/recording.h"
#include "piste/inspect/inspection.h"

namespace piste {

/// Replays the first hour as `replay` will with the configuration of an inspection, and mends what does not hold there:
///  - Where more than a hundredth of the positions or velocities is refused, their sigmas grow until that many are
///    within the gate: the first minutes saw a better sky.
///  - The clock takes the delay of the fixes, and the drift, that the whole log tells, so that the rows of a replay are
///    in the receiver's time, as long as the fixes are likelier with it; unless the receiver's log tells the clock
///    (`find_clock` is false). What the velocities are late by moves with it.
/// The lever arm stays as it was found: each round sees the same motion again.
/// `options` is what calibrate() was given, with one receiver; `vehicle`: what carries the IMU, if it does.
/// Nothing if no filter runs over the whole log with it.
std::optional<Calibration> settled(const Recording& recording, const ConditioningOptions& conditioning,
                                   const FilterOptions& options, const std::optional<VehicleOptions>& vehicle,
                                   bool find_clock, Calibration found);

/// Sets the noise of the IMU and the errors of the receiver to those of likeliest_noise() (tune/likeliest_noise.h) over
/// a quarter of an hour of motion, which tells drifts that the first minutes do not, and with the vehicle. `found` is
/// what settled() returned for the other arguments; `jobs`: filter runs at a time.
/// Nothing where there is not much more motion than calibrate() saw, where the whole log is not likelier with it, and
/// where the clock then drifts as none does.
std::optional<Calibration> retuned(const Recording& recording, const ConditioningOptions& conditioning,
                                   const FilterOptions& options, const std::optional<VehicleOptions>& vehicle,
                                   bool find_clock, const Calibration& found, std::size_t jobs);

/// Whether the clock drifts by no more than clocks do.
bool drifts_plausibly(const Calibration& found);

/// Whether the receiver's velocities contradict its positions over the whole log: without them the filter would have
/// the antenna, or the clock, elsewhere by many of its sigmas. Velocities that a receiver smooths by a model of its own
/// do so, and no delay mends them. So do those that show a vibration which the filter's means over a tenth of a second
/// do not: in a calm ride they make the clock drift by more than any clock does, which counts too. False without
/// velocities, and where positions alone tell little. (Of two estimates the one that presumes less is trusted: Hausman,
/// "Specification tests in econometrics", 1978.) Arguments are as those of settled().
bool velocities_contradict(const Recording& recording, const ConditioningOptions& conditioning,
                           const FilterOptions& options, const std::optional<VehicleOptions>& vehicle, bool find_clock,
                           const Calibration& found);

/// Whether the constraint of a vehicle contradicts the fixes over the whole log: with it the filter would have the
/// scales elsewhere by many of the sigmas that it has without. A body that sways on what carries it, and does not lean,
/// is no vehicle: the constraint makes its rotations smaller. Arguments are as those of settled().
bool vehicle_contradicts(const Recording& recording, const ConditioningOptions& conditioning,
                         const FilterOptions& options, const VehicleOptions& vehicle, bool find_clock,
                         const Calibration& found);

}  // namespace piste
