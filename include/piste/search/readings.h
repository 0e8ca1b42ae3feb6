#pragma once
/// Readings of the same logs, compared by the likelihood of a replay with each.

#include <functional>

#include "piste/configuration/replay_config.h"
#include "piste/inspect/inspection.h"

namespace piste {

/// Weighs the readings that the first inspection leaves open: which axes of the IMU point forward, right and down,
/// whether the receiver's velocities agree with its positions, in which unit rates without a label are. Each reading is
/// replayed over the whole log, an hour at most. Its weight is ln p, the log-likelihood of the innovations that all
/// readings predict.
///
/// A reading that gains more than ln(number of readings) + 3 over the first one is taken, or where the first does not
/// run. If the second best is within that bound of the best, both stand in `found.doubts`. `found.suspicions` has a
/// line about either. A question of which no reading runs changes nothing; nothing is thrown.
///
/// `configured`: writes and reads the configuration of an inspection as it is at the moment.
///
///     weigh_readings(found, configured);  // found.doubts: axes: +x +y +z or axes: -x -y +z, as likely
void weigh_readings(Inspection& found, const std::function<ReplayConfig(const Inspection&)>& configured);

}  // namespace piste
