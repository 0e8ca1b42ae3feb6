#pragma once
/// Closes the loop of an inspection: what it writes is replayed, and the verdict on that run changes it.

#include <functional>
#include <string>
#include <vector>

#include "piste/configuration/replay_config.h"
#include "piste/filter/run.h"
#include "piste/inspect/inspection.h"

namespace piste {

/// Replays the configuration of an inspection, and judges the run (diagnosis/diagnose.h). A cause that makes all of its
/// innovations likelier is taken into the calibration, and the configuration is replayed again: at most five rounds.
/// The most likely one stays. `found.rounds` has the verdict of each round, and what was taken after it.
///
/// A cause was fitted to the first minutes of motion. It is taken if the innovations of the whole log, an hour at most,
/// gain more than ln(number of causes) + 3 by it: with so many causes chance gains as much in one of twenty logs.
///
/// `configured`: writes and reads the configuration of an inspection as it is at the moment.
/// Where no replay runs, nothing is changed, and `found.rounds` is empty.
void take_causes(Inspection& found, const std::function<ReplayConfig(const Inspection&)>& configured,
                 const ProgressCallback& progress = {});

/// Withholds fixes of the first receiver: 10 s of each 20 s of what is no rest. Where
/// the errors at the ends of these windows are larger than their sigmas, more than chance lets them be in one of a
/// thousand logs, noise and drift of the IMU are made as much larger, three times at most. `found.suspicions` then
/// begins with a line about it. Innovations alone may not show it, as fixes correct the state before it drifts.
/// @pre take_causes(), with the same `configured`
void widen_by_withheld(Inspection& found, const std::function<ReplayConfig(const Inspection&)>& configured);

}  // namespace piste
