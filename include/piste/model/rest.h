#pragma once
/// Zero-velocity and zero-angular-rate updates (ZUPT, ZARU). A stationary body has zero velocity, and its only rotation
/// is the Earth's.
///
///     0 = v + n_v      mean gyro = (1 + scale) R_wbᵀ ω_ie + bias + drift + n_ω
///
/// A standing person sways, so n_v and n_ω describe the sway rather than the noise of the sensors.

#include "piste/core/options.h"
#include "piste/model/measurement.h"

namespace piste {

/// Zero velocity. Linearised at zero velocity instead of the estimated one, whose noise would give false information on
/// the heading.
Linearization linearize_zero_velocity(const RestOptions& rest, const Estimate& x);

/// Zero rate. `mean_gyro`: the measured mean rate over `duration` seconds of rest, in body axes, not corrected.
/// `noise`: density of the gyroscopes' white noise.
Linearization linearize_zero_rate(const RestOptions& rest, const Vector3d& mean_gyro, double duration, double noise,
                                  const Estimate& x, const Vector3d& earth_rate, const Vector3d& gravity);

/// A stretch of rest that ended at `time`.
struct RestFix {
  double time = 0, duration = 0;
  Vector3d mean_gyro = Vector3d::Zero();  ///< measured, body axes
};

/// The ZUPT and ZARU. They come from the rest detector and are not in the log. An update outside the gate is never
/// used, because it would stop a body that moves.
struct ZeroUpdates : MeasurementType<RestFix> {
  static constexpr std::string_view kName = "rest";
  static constexpr bool kAdapted = false;  // its noise is the sway of a body, which is coloured and stated as such
  static constexpr std::array kChannels{MeasurementChannel{.name = "velocity", .readmitted = false},
                                        MeasurementChannel{.name = "rate", .readmitted = false, .axes = kBodyAxes}};
  static std::optional<Linearization> linearize(const RestFix& fix, int sensor, int channel,
                                                const MeasurementContext& context, const Estimate& x);
};

}  // namespace piste
