#pragma once
/// Two IMUs on one plate, brought together: one clock, one place, one set of axes; and the phases of their run.

#include <cstdint>
#include <optional>
#include <vector>

#include "piste/core/log.h"

namespace piste {

/// Both IMUs at the samples of the body IMU, GPS time. Rates and forces are means over (time − interval, time].
struct AlignedImus {
  double interval = 0;                    ///< median one
  double low_pass = 0;                    ///< [Hz] that both IMUs' signals went through; 0 = none
  std::vector<double> time;               ///< [s]
  std::vector<Vector3d> gyro, accel;      ///< as the body IMU measured them, body axes
  std::vector<Vector3d> reference_gyro;   ///< of the reference, turned into b by the boresight
  std::vector<Vector3d> reference_accel;  ///< likewise, and moved to b by the lever arm
  std::vector<std::uint8_t> usable;       ///< 0 where either IMU is silent, or where the body IMU clips
};

/// Stretches of a log; what it does not have is nothing.
struct Phases {
  std::optional<Interval> before, run, after;  ///< at rest before the start, under way, at rest after the stop
};

}  // namespace piste
