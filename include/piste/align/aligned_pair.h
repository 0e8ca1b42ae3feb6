#pragma once
/// The alignment of every IMU of a configuration with its reference, for `align` and `compare`.

#include <functional>
#include <string>
#include <vector>

#include "piste/align/align_config.h"
#include "piste/condition/time_sync.h"
#include "piste/fit/imu_fit.h"

namespace piste {

/// One body IMU and its reference.
struct AlignedPair {
  const MountedImu& imu;
  std::vector<ImuSample> body;
  const std::vector<ImuSample>& reference;
  Alignment alignment;
  AlignedImus aligned;
  std::string folder;  ///< of its outputs, with a `/` at the end; empty if there is only one IMU
};

/// Reads and aligns one IMU after the other, and calls `take` with each. `progress` gets the number of IMUs done, first
/// 0, and the number of all. Throws as reading and aligning do.
void for_each_pair(const AlignConfig& config, const std::function<void(std::size_t, std::size_t)>& progress,
                   const std::function<void(const AlignedPair&)>& take);

/// The errors of the IMU in the phases of the configuration, or else in the phases detected in the signals. Throws
/// DataError with the name of the IMU's log.
Findings findings_of(const AlignConfig& config, const AlignedPair& pair);

}  // namespace piste
