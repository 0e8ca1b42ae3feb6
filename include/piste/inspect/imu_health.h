#pragma once
/// What an IMU's log says of itself, before anybody has said what it should be.

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "piste/core/log.h"
#include "piste/inspect/sampling.h"
#include "piste/inspect/suspicion.h"
#include "piste/io/row_fault.h"

namespace piste {

/// Three like axes, in the units of the recording: SI, as its labels have it; increments are divided by their interval.
struct TriadHealth {
  Vector3d smallest, largest;
  Vector3d quantum;  ///< smallest step between values of the log as it stands (not divided); 0 = none seen
  Vector3d noise;    ///< density of the white noise at rest [unit/√Hz]; NaN without rest
  Vector3d mean;     ///< at rest; NaN without
  std::array<std::size_t, 3> clipped{};  ///< samples at a limit that the axis reaches again and again, and never passes
  Vector3d limit = Vector3d::Zero();     ///< that limit, 0 where there is none
  std::size_t spikes = 0;                ///< samples that no body can do
  double first_spike = 0;                ///< time of the first of them
};

struct ImuHealth {
  Sampling sampling;
  bool increments = false;
  TriadHealth gyro, accel;
  std::vector<Interval> rest;  ///< at least two seconds each, in which nothing turns and nothing shakes
  /// Median magnitude of the specific force, at rest where there is rest. Some 9.8 m/s² where its label is right.
  double force = 0;
  /// Another unit than its label's, where the magnitude of gravity says so.
  struct WrongUnit {
    LogFault fault;
    double factor;  ///< by which the values are to be divided
  };
  std::optional<WrongUnit> force_unit;
  /// Whether gravity stands in the forces: without it their magnitude is small at rest and large in motion.
  bool has_gravity = true;
  bool fast_rates = false;       ///< so many rates no body can have: they must be degrees
  std::vector<Interval> frozen;  ///< the very same row again and again
  std::size_t magnetic_rows = 0, temperature_rows = 0;
};

/// @pre a time-ordered recording, as read_imu gives it, of two rows or more
ImuHealth imu_health(const ImuRecording& imu);

/// What looks wrong with it; `faults` are the rows that its reader refused.
std::vector<Suspicion> suspicions(const ImuHealth& health, const RowFaults& faults, const std::string& file);

}  // namespace piste
