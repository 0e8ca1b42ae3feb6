#pragma once
/// Delays as one run estimated them, and held there in the runs that are compared. Where a delay is estimated, a change
/// of noise moves it by microseconds, fixes change over from one sample of the IMU to the next, and the likelihood
/// leaps.

#include "piste/core/options.h"
#include "piste/filter/initial_state.h"

namespace piste {

/// `start` with the delays, and the drift of the clock, that a run `estimated`.
Start with_delays(Start start, const Estimate& estimated);

/// Options with which these do not move.
FilterOptions holding_delays(FilterOptions options);

/// Whether a run with these options moves any of them.
bool estimates_delays(const FilterOptions& options);

}  // namespace piste
