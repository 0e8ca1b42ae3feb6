#pragma once
/// One simulated run, replayed, and held against its truth and against the bound.

#include "piste/consistency/consistency.h"
#include "piste/sim/scenario.h"

namespace piste {

/// Epochs of the runs of a scenario at which errors are looked at.
EpochGrid epoch_grid(const Scenario& scenario);

/// Simulates with the seed and replays (experiment/replay.h) as the scenario's `replay` says, from a start that is
/// drawn about the truth or found. The bound is the covariance of the same filter and smoother run on perfect sensors
/// from the truth: their linearisation is then at the truth, and all else (schedule of the fixes, rests, clipped
/// samples, noise of the sensors, white part of the reference attitudes) the same. Where nothing is known of the
/// heading, the bound knows as little. Throws DataError where the start is not found.
ComparedRun run_trial(const Scenario& scenario, std::uint64_t seed);

}  // namespace piste
