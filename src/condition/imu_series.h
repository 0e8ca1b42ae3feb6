#pragma once
/// Several IMUs at the epochs of the first, with the faults of single samples.

#include <cstdint>
#include <optional>
#include <vector>

#include "piste/core/log.h"

namespace piste {

/// Gyroscopes or accelerometers of one IMU, epoch by epoch: means over each.
struct ImuTriad {
  std::vector<Vector3d> value;
  std::vector<std::uint8_t> bad;  ///< bit i: axis i is not usable
  std::vector<ImuFault> why;      ///< of each epoch, where a bit is set
};

struct ImuSeries {
  ImuTriad gyro, accel;
};

/// The samples of an IMU at `epochs`, which may be its own. Increments of other epochs are differences of a cubic
/// spline through their sums, so that no motion is lost or counts twice. A sample is not usable where it is clipped,
/// replaces a spike or fills a gap. Nor is it where samples repeat to the last digit for 0.1 s and ten samples at
/// least: then the IMU is stuck.
ImuSeries at_epochs(const std::vector<ImuSample>& unit, const std::vector<ImuSample>& epochs);

}  // namespace piste
