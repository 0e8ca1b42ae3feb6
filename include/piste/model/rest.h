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

/// Some rest that has ended at `time`.
struct RestFix {
  double time = 0, duration = 0;
  Vector3d mean_gyro = Vector3d::Zero();  ///< measured, body axes
};

/// The zero updates of a body that stands: it is told by the rest detector, not logged. A body that moves must not be
/// stopped, so that a residual outside the gate is never taken.
struct ZeroUpdates : MeasurementType<RestFix> {
  static constexpr std::string_view kName = "rest";
  static constexpr std::array kChannels{MeasurementChannel{.name = "velocity", .readmitted = false},
                                        MeasurementChannel{.name = "rate", .readmitted = false}};
  static std::optional<Linearization> linearize(const RestFix& fix, int sensor, int channel,
                                                const MeasurementContext& context, const Estimate& x);
};

}  // namespace piste
