#pragma once
/// Weighs other readings of the same logs against the one that an inspection found.

#include <functional>

#include "piste/configuration/replay_config.h"
#include "piste/inspect/inspection.h"

namespace piste {

/// Asks what stayed a guess: which axes of the IMU point forward and right, whether a car carries it, whether the
/// receiver's velocities agree with its positions, in which unit rates without a label are. Each answer is a reading:
/// it is replayed over the whole log, an hour at most, and weighed by ln p, the log-likelihood of the innovations of
/// the sources that all readings predict.
///
/// A reading that gains more than ln(number of readings) + 3 over the one that was found is taken. Where the second is
/// within that bound of the first, both stand in `found.doubts`, and `found.suspicions` has a line about them. A
/// question whose other readings do not run leaves no doubt.
///
/// `configured`: writes and reads the configuration of an inspection as it is at the moment.
void weigh_readings(Inspection& found, const std::function<ReplayConfig(const Inspection&)>& configured);

}  // namespace piste
