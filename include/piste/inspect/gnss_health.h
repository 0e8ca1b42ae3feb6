#pragma once
/// Examines the log of a receiver alone: sampling, sigmas, scatter, jumps, repeated fixes, velocities.

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <string>
#include <vector>

#include "piste/core/log.h"
#include "piste/inspect/sampling.h"
#include "piste/inspect/suspicion.h"
#include "piste/io/row_fault.h"

namespace piste {

/// How the velocities of a log fit its positions: velocity(t) ≈ scale · axes · d(position)/dt (t − delay).
struct VelocityFit {
  /// The signed permutation of north-east-down that fits the velocities. The identity, unless another one fits far
  /// better.
  Matrix3d axes = Matrix3d::Identity();
  double scale = 1;              ///< 1 unless another one fits far better: 3.6 for km/h
  bool interchanged = false;     ///< whether latitude and longitude must be interchanged for this
  double residual = 0;           ///< median residual [m/s]
  double residual_as_given = 0;  ///< the same with the velocities as given in the log
  double delay = 0,
         sigma_delay = 0;  ///< of the velocities [s]; the sigma is infinite if the motion does not determine it

  bool as_given() const { return axes.isIdentity() && scale == 1 && !interchanged; }
  /// The delay, if the velocities are right otherwise and their delay is significant: beyond 3 sigmas, and beyond what
  /// a receiver's own smoothing may cause.
  std::optional<double> known_delay() const {
    constexpr double kLeast = 0.01, kSure = 3;  // s; sigmas
    const bool sure = as_given() && std::abs(delay) > std::max(kLeast, kSure * sigma_delay);
    return sure ? std::optional(delay) : std::nullopt;
  }
};

/// A fix that is `distance` [m] away from where its neighbours place it.
struct PositionJump {
  double time = 0, distance = 0;
};

/// With a longer interval between fixes the track between them is unknown: it determines neither rest nor scatter,
/// nor axes and units of an IMU. [s]
inline constexpr double kSparseFixes = 3;

/// The result.
struct GnssHealth {
  Sampling sampling;
  std::size_t without_fix = 0;
  std::array<std::size_t, kQualities> qualities{};  ///< fixes of each FixQuality
  std::size_t without_sigma = 0;                    ///< fixes with a sigma that is not positive
  Vector3d smallest_sigma = Vector3d::Zero(), median_sigma = Vector3d::Zero(), largest_sigma = Vector3d::Zero();
  std::size_t velocities = 0;           ///< fixes that have a velocity
  double sigma_velocity = 0;            ///< median of their sigmas, of one axis [m/s]; 0: none are stated
  std::vector<Interval> rest;           ///< times of at least 5 s in which the antenna does not move
  Vector3d rest_scatter, noise;         ///< 1-sigma at rest, and white part from fix to fix [m]; NaN: unknown
  double speed = 0, top_speed = 0;      ///< median in motion, and largest without outliers [m/s]
  double lowest = 0, highest = 0;       ///< height [m]
  Vector3d quantum;                     ///< quantization step of north, east, down [m]; 0 if smaller than 1 mm
  std::vector<PositionJump> jumps;      ///< fixes with errors far beyond the other fixes and their sigmas
  std::vector<Interval> repeated;       ///< times of identical fixes while the antenna moves
  std::optional<VelocityFit> velocity;  ///< nothing without velocities or motion
};

/// Examines a log. @pre fixes are in the order of time, as read_gnss gives them
GnssHealth gnss_health(const GnssRecording& gnss);

/// Lists the faults of the log. `faults`: the rows that could not be read.
std::vector<Suspicion> suspicions(const GnssHealth& health, const RowFaults& faults, const std::string& file);

}  // namespace piste
