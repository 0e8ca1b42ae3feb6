#pragma once
/// What the filter itself tells of a pair of logs: how far their clocks are apart, where the antenna sits, and how
/// noisy the IMU is in motion.

#include <cstddef>
#include <optional>

#include "piste/core/options.h"
#include "piste/inspect/inspection.h"

namespace piste {

/// Replays the first minutes of motion with lever arm and delay as states, for several clock offsets and noises, and
/// keeps those for which the innovations are likeliest (tune/evidence.h). The noise of the IMU and the
/// errors of the receiver are those of likeliest_noise() (tune/likeliest_noise.h), with `jobs` filter runs at a time.
/// Where the last minutes of motion are far from the first, the same filter tells the offset there too, and so the
/// drift of the clock if it is significant.
/// `clock_sigma`: how well the offset in `conditioning` is known [s]. Where that is more than 20 ms, offsets up to half
/// a second beside it are tried too.
/// Nothing if no candidate starts. @pre `options` has one receiver, `recording` too.
std::optional<Calibration> calibrate(const Recording& recording, ConditioningOptions conditioning,
                                     FilterOptions options, double clock_sigma, std::size_t jobs = 1);

}  // namespace piste
