#pragma once
/// What align and compare share: the alignment of every IMU of a configuration with its reference.

#include <functional>
#include <string>
#include <vector>

#include "app.h"
#include "piste/condition/time_sync.h"
#include "piste/experiment/align_config.h"
#include "piste/files/output.h"

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

/// Reads and aligns one IMU after the other, and calls `take` with each. Throws what reading and aligning throw.
void for_each_pair(const AlignConfig& config, Progress& progress, const std::function<void(const AlignedPair&)>& take);

/// Writes alignment.json, aligned.csv, alignment.html and figures/*.svg.
void write_alignment(OutputFolder& output, const AlignConfig& config, const AlignedPair& pair);

}  // namespace piste
