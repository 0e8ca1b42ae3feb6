#pragma once
/// Reads a recording at rest: stretches of even samples, and their Allan variance.

#include "piste/inspect/imu_health.h"
#include "piste/recordings/allan.h"

namespace piste {

/// A recording and its properties.
struct ReadRecording {
  AllanRecording found;
  ImuHealth health;
};

/// Throws DataError as find_noise does.
ReadRecording read_at_rest(const AllanSource& source, const AllanOptions& options);

}  // namespace piste
