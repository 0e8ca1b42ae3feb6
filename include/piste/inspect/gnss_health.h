#pragma once
/// What a receiver's log says of itself.

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "piste/core/log.h"
#include "piste/inspect/sampling.h"
#include "piste/inspect/suspicion.h"
#include "piste/io/row_fault.h"

namespace piste {

/// How the velocities fit what the positions do: velocity(t) ≈ scale · axes · d(position)/dt (t − delay).
struct VelocityFit {
  /// The signed permutation, of north-east-down, that explains the velocities; 1 unless another one does far better.
  Matrix3d axes = Matrix3d::Identity();
  double scale = 1;           ///< likewise: 3.6 where the velocities are km/h
  bool interchanged = false;  ///< they fit once latitude and longitude are interchanged
  double residual = 0;        ///< median of what is left, and of what is left with the velocities as they stand [m/s]
  double residual_as_given = 0;
  double delay = 0, sigma_delay = 0;  ///< of the velocities; infinite sigma where the motion does not tell it [s]

  bool as_given() const { return axes.isIdentity() && scale == 1 && !interchanged; }
};

/// A fix that lies off its neighbours, by `distance` [m].
struct PositionJump {
  double time = 0, distance = 0;
};

struct GnssHealth {
  Sampling sampling;
  std::size_t without_fix = 0;
  std::array<std::size_t, 7> qualities{};  ///< fixes of each FixQuality
  std::size_t without_sigma = 0;           ///< fixes with a sigma that is not positive
  Vector3d smallest_sigma = Vector3d::Zero(), median_sigma = Vector3d::Zero(), largest_sigma = Vector3d::Zero();
  std::size_t velocities = 0;       ///< fixes that have one
  std::vector<Interval> rest;       ///< of five seconds or more, in which the antenna does not move
  Vector3d rest_scatter, noise;     ///< 1-sigma at rest, and from fix to fix (the white part); NaN where not known [m]
  double speed = 0, top_speed = 0;  ///< median while moving, and the largest but for outliers [m/s]
  double lowest = 0, highest = 0;   ///< height [m]
  Vector3d quantum;                 ///< what north, east, down are multiples of [m]; 0 where finer than 1 mm
  std::vector<PositionJump> jumps;  ///< fixes far off, by what the others are and by what they claim
  std::vector<Interval> repeated;   ///< the same fix again and again, while the antenna moves on
  std::optional<VelocityFit> velocity;  ///< where there are velocities, and motion
};

/// @pre fixes in order of time, as read_gnss gives them
GnssHealth gnss_health(const GnssRecording& gnss);

/// What looks wrong with it; `faults` are the rows that its reader refused.
std::vector<Suspicion> suspicions(const GnssHealth& health, const RowFaults& faults, const std::string& file);

}  // namespace piste
