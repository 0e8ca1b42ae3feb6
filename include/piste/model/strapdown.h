#pragma once
/// Strapdown mechanization in the world frame: from IMU increments to attitude, velocity and position.
///
///     R_wb' = −[ω_ie] R_wb + R_wb [ω_ib]      v' = R_wb f + g(p) − 2 ω_ie × v      p' = v
///
/// Within a step, rate and specific force are taken to change linearly: each has a mean and a slope. Coning, sculling
/// and the split of a step at a measurement all follow from this model, for any step lengths. With the slope (m₂ −
/// m₁)/dt it gives the usual corrections α₁ × α₂ / 12. Source: Savage 1998; Groves, section 5.5. The rotation of the
/// velocity increment is exact, not only α × u / 2.

#include <utility>

#include "piste/core/estimate.h"
#include "piste/core/log.h"

namespace piste {

/// One step: increments over `dt`, and the slopes of rate and specific force within it, in body axes.
struct ImuStep {
  double dt = 0;
  Vector3d dtheta, dvel;
  Vector3d rate_slope, force_slope;

  Vector3d mean_rate() const { return dtheta / dt; }
  Vector3d mean_force() const { return dvel / dt; }
};

/// The step of the sample `now`. Its slopes come from a parabola through `now` and both neighbours. A neighbour that is
/// null, does not touch `now` or fills a gap is not used: the slopes then come from a line through the other neighbour,
/// or are zero.
ImuStep make_step(const ImuSample* before, const ImuSample& now, const ImuSample* after);

/// The mean rate of the neighbours of `now`, as measured: of both if both adjoin it, else of the one that does, else
/// zero. The white noise of the mean of both is uncorrelated with that of the rate at any time within `now`: the
/// neighbours' noises enter that rate equally, with opposite signs.
Vector3d neighbour_rate(const ImuSample* before, const ImuSample& now, const ImuSample* after);

/// Splits a step in two at `tau` seconds after its start. @pre 0 < tau < dt
std::pair<ImuStep, ImuStep> split(const ImuStep& step, double tau);

/// The step without the estimated errors of the IMU: true = (1 + S + M)⁻¹ (measured − bias − drift − G f), with the
/// matrices of model/imu_error_model.h.
ImuStep correct(const ImuStep& measured, const Estimate& x);

/// The same of an angular rate, where the accelerometers measure `force` meanwhile.
Vector3d corrected_rate(const Vector3d& measured, const Vector3d& force, const Estimate& x);

/// Rotation vector of a corrected step, with coning.
Vector3d coned_rotation(const ImuStep& step);

/// Velocity increment of a corrected step, in the body axes at its start, with exact rotation and sculling.
Vector3d sculled_velocity(const ImuStep& step);

/// Advances attitude, velocity and position of `x` by one corrected step. The other blocks stay as they are.
/// `earth_rate` and `gravity` are in w, and `gravity` is valid near the position.
void mechanize(Estimate& x, const ImuStep& corrected, const Vector3d& earth_rate, const Gravity& gravity);

}  // namespace piste
