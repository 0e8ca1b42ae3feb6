#pragma once
/// Signals of two IMUs on one plate after their alignment, with one clock, one set of axes and one place; and the
/// phases of their run.

#include <cstdint>
#include <optional>
#include <vector>

#include "piste/core/log.h"

namespace piste {

/// Signals of both IMUs at the sample times of the body IMU, in GPS time. Rates and forces are means over (time −
/// interval, time].
struct AlignedImus {
  double interval = 0;                    ///< median sample interval [s]
  double low_pass = 0;                    ///< cut-off of the low-pass of both signals [Hz]; 0 = none
  std::vector<double> time;               ///< [s]
  std::vector<Vector3d> gyro, accel;      ///< as the body IMU measured them, body axes
  std::vector<Vector3d> reference_gyro;   ///< of the reference, turned into body axes by the boresight
  std::vector<Vector3d> reference_accel;  ///< likewise, and moved to the body IMU by the lever arm
  std::vector<std::uint8_t> usable;       ///< 0 where either IMU has no sample or the body IMU clips
};

/// The three phases of a run. A phase that the log does not have is empty.
struct Phases {
  std::optional<Interval> before, run, after;  ///< at rest before the start, under way, at rest after the stop
};

}  // namespace piste
