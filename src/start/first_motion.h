#pragma once
// Motion of the antenna at one time: position, velocity and acceleration from the fixes around it.

#include <array>
#include <vector>

#include "piste/core/log.h"
#include "piste/core/options.h"

namespace piste {

/// Motion of the antenna at one time, in w. The axes of the local level are independent: `covariance[i]` is that of
/// (position, velocity, acceleration) along its axis i.
struct FirstMotion {
  Matrix3d R_wn;  ///< the local level at the first of the fixes
  Vector3d position, velocity, acceleration;
  std::array<Matrix3d, 3> covariance;

  Vector3d sigma(int quantity) const;  ///< along n; 0: position, 1: velocity, 2: acceleration
};

using FixPlace = std::vector<GnssFix>::const_iterator;

/// The first fix from `first` on that does not contradict the next one while the next two agree. Two fixes agree if a
/// body no faster than `fastest` [m/s] can have been at both.
FixPlace past_outliers(const std::vector<GnssFix>& fixes, FixPlace first, double fastest);

/// The motion at `time` from the fixes of the next seconds, by least squares. The acceleration is that of a body in a
/// vehicle or on skis (`start.acceleration`), and varies within a second. The effect of this variation on later fixes
/// is added to their variances. Where the residuals exceed the sigmas of the fixes, the covariance is multiplied by
/// their mean square. A first fix that contradicts the next two is skipped.
/// @pre There is a fix.
FirstMotion first_motion(const World& world, const std::vector<GnssFix>& fixes, const GnssOptions& options, double time,
                         const StartOptions& start);

}  // namespace piste
