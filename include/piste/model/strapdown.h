#pragma once
/// Mechanization in the world frame: from increments to attitude, velocity and position.
///
///     R_wb' = −[ω_ie] R_wb + R_wb [ω_ib]      v' = R_wb f + g(p) − 2 ω_ie × v      p' = v
///
/// Within a step the rate and the force are lines, mean and slope, so that coning, sculling and the split of a step
/// at a measurement follow from one model for any step lengths: with slope (m₂ − m₁)/dt the usual one-sample
/// corrections α₁ × α₂ / 12 come out. Source: Savage 1998; Groves, section 5.5; the rotation of the velocity
/// increment is exact and not only α × u / 2.

#include <utility>

#include "piste/core/estimate.h"
#include "piste/core/log.h"

namespace piste {

/// Increments over `dt` and the slopes of rate and specific force within it, body axes.
struct ImuStep {
  double dt = 0;
  Vector3d dtheta, dvel;
  Vector3d rate_slope, force_slope;

  Vector3d mean_rate() const { return dtheta / dt; }
  Vector3d mean_force() const { return dvel / dt; }
};

/// The step of `now`, its slopes from the parabola through its neighbours; nullptr, or a neighbour that does not
/// touch it or is a filled gap, leaves a line through the other one, or no slope.
ImuStep make_step(const ImuSample* before, const ImuSample& now, const ImuSample* after);

/// Cuts a step at `tau` after its start, 0 < tau < dt.
std::pair<ImuStep, ImuStep> split(const ImuStep& step, double tau);

/// The step with the estimated errors of the IMU taken out: true = (measured − bias − drift) / (1 + scale).
ImuStep correct(const ImuStep& measured, const Estimate& x);

/// Rotation vector of a corrected step, coning included.
Vector3d coned_rotation(const ImuStep& step);

/// Velocity increment of a corrected step in the body axes of its start: rotation exact, sculling included.
Vector3d sculled_velocity(const ImuStep& step);

/// Carries attitude, velocity and position over one corrected step; the other blocks stay. `gravity` in w, valid
/// near the position.
void mechanize(Estimate& x, const ImuStep& corrected, const Vector3d& earth_rate, const Gravity& gravity);

}  // namespace piste
