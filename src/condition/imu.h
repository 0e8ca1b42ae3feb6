#pragma once
/// The IMU's part of conditioning.

#include "piste/core/log.h"
#include "piste/core/options.h"

namespace piste {

/// Appends the samples, the magnetic field and their counts to the log; see `condition()`.
void condition_imu(const ImuRecording& recording, const ConditioningOptions& options, Log& log);

}  // namespace piste
