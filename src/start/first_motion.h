#pragma once
// How the antenna moves at a time: position, velocity and acceleration from the fixes around it.

#include <array>
#include <vector>

#include "piste/core/log.h"
#include "piste/core/options.h"

namespace piste {

/// Motion of the antenna at a time, in w. The axes of the local level are independent: `covariance[i]` is that of
/// (position, velocity, acceleration) along its axis i.
struct FirstMotion {
  Matrix3d R_wn;  ///< the local level at the first of the fixes
  Vector3d position, velocity, acceleration;
  std::array<Matrix3d, 3> covariance;

  Vector3d sigma(int quantity) const;  ///< along n; 0: of the position, 1: of the velocity, 2: of the acceleration
};

using FixPlace = std::vector<GnssFix>::const_iterator;

/// The first fix from `first` on that does not contradict the two after it, which agree: one body, no faster than
/// `fastest` [m/s], can have been at both.
FixPlace past_outliers(const std::vector<GnssFix>& fixes, FixPlace first, double fastest);

/// The motion at `time` from the fixes of the next seconds, by least squares. The acceleration is that of a body in a
/// vehicle or on skis (`start.acceleration`), and wanders within a second; what it makes of a fix that lies later is
/// added to the fix's variance. Residuals beyond the sigmas of the fixes widen the covariance by their mean square. A
/// first fix that contradicts the next two is passed over.
/// @pre there is a fix
FirstMotion first_motion(const World& world, const std::vector<GnssFix>& fixes, const GnssOptions& options, double time,
                         const StartOptions& start);

}  // namespace piste
