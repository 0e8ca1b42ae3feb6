#pragma once
/// Whether the estimates of the first minutes of motion hold over the whole log.

#include <cstddef>
#include <optional>

#include "piste/inspect/inspection.h"
#include "search/whole_log.h"
#include "search/work.h"

namespace piste {

/// Replays the first hour as `replay` will with the configuration of an inspection, and mends what does not hold there:
///  - Where more than a hundredth of the positions or velocities is refused, their sigmas grow until all but that many
///    are within the gate: the first minutes saw a better sky. Where calibrate() saw all of the motion, and after
///    retuned(), three hundredths may be refused: errors have long tails. They stop growing where that makes the
///    fixes less likely, each refused one counted as an outlier.
///  - The clock takes the delay of the fixes, and the drift, of the whole log, so that the rows of a replay are
///    in the receiver's time, as long as the fixes are more likely with it; unless the receiver's log states the clock
///    (`find_clock` is false). What the velocities are late by moves with it.
/// The lever arm stays as it was found: each round sees the same motion again.
/// Nothing if no filter runs over the whole log with it.
std::optional<Calibration> settled(WholeLog log, Calibration found, const Work& work = {});

/// Sets the noise of the IMU and the errors of the receiver to those of likeliest_noise() (tune/likeliest_noise.h) over
/// a quarter of an hour of motion, which determines drifts that the first minutes do not, and with the vehicle; a
/// coloured error of the receiver is tried where these had none. `found` is what settled() returned for the log;
/// `jobs`: filter runs at a time. Nothing where there is not much more motion than calibrate() saw, where the whole log
/// is not likelier with it, and where the clock then drifts as none does.
std::optional<Calibration> retuned(WholeLog log, const Calibration& found, std::size_t jobs, const Work& work = {});

/// What both cost, as far as it is known beforehand, in rows of the IMU that are filtered once.
double cost_of_settling(const WholeLog& log);
double cost_of_retuning(const WholeLog& log, std::size_t jobs);

}  // namespace piste
