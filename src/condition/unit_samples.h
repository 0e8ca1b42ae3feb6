#pragma once
/// Several IMUs at the epochs of the first, with what is wrong with single samples.

#include <cstdint>
#include <optional>
#include <vector>

#include "piste/core/log.h"

namespace piste {

/// Gyroscopes or accelerometers of one unit, epoch by epoch: means over each.
struct UnitTriad {
  std::vector<Vector3d> value;
  std::vector<std::uint8_t> bad;  ///< bit i: axis i says nothing
  std::vector<UnitFault> why;     ///< of each epoch, where a bit is set
};

struct UnitSamples {
  UnitTriad gyro, accel;
};

/// The samples of a unit at `epochs`, which may be its own. Increments of other epochs are differences of a cubic
/// spline through their sums, so that nothing of the motion is lost or counts twice. A sample says nothing where it is
/// clipped, replaces a spike, fills a gap, or repeats the one before to the last digit for a tenth of a second and ten
/// samples at least: then the unit is stuck.
UnitSamples at_epochs(const std::vector<ImuSample>& unit, const std::vector<ImuSample>& epochs);

}  // namespace piste
