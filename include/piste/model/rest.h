#pragma once
/// What a body that stands still tells: its velocity is zero, and so is its rate but for the Earth's.
///
///     0 = v + n_v      mean gyro = (1 + scale) R_wbᵀ ω_ie + bias + drift + n_ω
///
/// A standing person sways, so that n_v and n_ω are the sway's and not the sensors'.

#include "piste/core/options.h"
#include "piste/model/measurement.h"

namespace piste {

/// Linearised at zero velocity, not at the estimated one: jitter of the estimate must not tell the heading.
Linearization linearize_zero_velocity(const RestOptions& rest, const Estimate& x);

/// `mean_gyro`: measured mean rate over `duration` of rest, body axes, uncorrected. `noise`: density of the gyro.
Linearization linearize_zero_rate(const RestOptions& rest, const Vector3d& mean_gyro, double duration, double noise,
                                  const Estimate& x, const Vector3d& earth_rate);

}  // namespace piste
