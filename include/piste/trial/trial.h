#pragma once
/// One trial: a simulated run that is replayed and compared with its truth and with the Cramér-Rao bound.

#include "piste/batch/batch.h"
#include "piste/consistency/consistency.h"
#include "piste/sim/scenario.h"

namespace piste {

/// The epochs at which the errors of a scenario's runs are evaluated.
EpochGrid epoch_grid(const Scenario& scenario);

/// Simulates a run with the seed and replays it (replay/replay.h) as the scenario's `replay` states. The start is drawn
/// about the truth, or estimated. The bound is the covariance of the same filter and smoother with perfect sensors and
/// the true start. So they are linearised at the truth, and all else is the same (times of the fixes, stationary times,
/// clipped samples, noise of the sensors, white part of the reference attitudes). If the heading is unknown to the
/// replay, it is unknown to the bound too. `batch`: the solver for a scenario that asks for a batch. Throws DataError
/// if the start is not found, ConfigError if a batch is needed and missing.
ComparedRun run_trial(const Scenario& scenario, std::uint64_t seed, const BatchSolver& batch = {});

}  // namespace piste
