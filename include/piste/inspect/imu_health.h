#pragma once
/// Examines the log of an IMU alone, without knowledge of its sensor: sampling, noise, clipping, rest, units.

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "piste/core/log.h"
#include "piste/inspect/sampling.h"
#include "piste/inspect/suspicion.h"
#include "piste/io/row_fault.h"

namespace piste {

/// Three gyroscopes or three accelerometers, in SI if the log's units are right. Increments are divided by their
/// interval.
struct TriadHealth {
  Vector3d smallest, largest;
  Vector3d quantum;                      ///< smallest step between values of the log (not divided); 0: unknown
  Vector3d repeated;                     ///< share of the values that repeat the row before
  Vector3d noise;                        ///< density of the white noise at rest [unit/√Hz]; NaN without rest
  Vector3d mean;                         ///< at rest; NaN without rest
  std::array<std::size_t, 3> clipped{};  ///< samples at a limit that is reached often and never exceeded
  Vector3d limit = Vector3d::Zero();     ///< that limit; 0 if no sample is clipped
  std::size_t spikes = 0;                ///< samples that no motion of a body explains
  double first_spike = 0;                ///< time of the first of them
  /// Isolated samples that the motion around does not explain either. Conditioning interpolates them.
  std::size_t isolated = 0;
  double first_isolated = 0;  ///< time of the first of them
};

/// The result.
struct ImuHealth {
  Sampling sampling;
  bool increments = false;
  TriadHealth gyro, accel;
  std::vector<Interval> rest;  ///< stationary times: at least 2 s without rotation and vibration
  /// Median magnitude of the specific force, at rest if there is rest. About 9.8 m/s² if the unit is right.
  double force = 0;
  /// The fault and the factor of a wrong unit, if the magnitude of gravity shows one.
  struct WrongUnit {
    LogFault fault;
    double factor;  ///< by which the values are to be divided
  };
  std::optional<WrongUnit> force_unit;
  /// Whether the forces contain gravity. Without it their magnitude is small at rest and large in motion.
  bool has_gravity = true;
  bool fast_rates = false;       ///< whether rates are too fast for any body in rad/s: the unit must be degrees
  std::vector<Interval> frozen;  ///< times in which all rows are identical
  std::size_t magnetic_rows = 0, temperature_rows = 0;
};

/// Examines a log. `moving`: times, in the order of time, in which the body is known to move: a smooth ride looks as
/// rest does. @pre rows are in the order of time, as read_imu gives them, and at least two
ImuHealth imu_health(const ImuRecording& imu, const std::vector<Interval>& moving = {});

/// That rows are too far apart for a body's motion, if they are.
std::optional<Suspicion> low_rate(const Sampling& sampling, const std::string& file);

/// Lists the faults of the log. `faults`: the rows that could not be read.
std::vector<Suspicion> suspicions(const ImuHealth& health, const RowFaults& faults, const std::string& file);

}  // namespace piste
