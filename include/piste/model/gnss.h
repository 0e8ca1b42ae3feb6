#pragma once
/// GNSS position and velocity of an antenna on a lever arm, with delay and a coloured position error.
///
///     y_p = p + R l − v_a τ + d          y_v = v_a − a τ
///     v_a = v + R (ω × l) − ω_ie × R l   ω = ω_ib, a ≈ R f + g − 2 ω_ie × v
///
/// l lever arm, τ delay (a fix stamped t is of t − τ), d coloured error. Jacobians about the error of estimate.h.

#include "piste/core/options.h"
#include "piste/model/measurement.h"

namespace piste {

/// Position of a fix. The white part of its sigma is what `drift` leaves of the total, at least 10 %. The lever arm is
/// that of the estimate.
Linearization linearize_position(const GnssFix& fix, const std::optional<GaussMarkov>& drift, const Estimate& x,
                                 const BodyMotion& motion, const Vector3d& earth_rate, const Gravity& gravity);

/// Velocity of a fix; `fix.velocity` must be there. Two rows where down was not measured. Its noise is that of the fix
/// and of the rate on the lever arm. `still`: the heading gains nothing from a velocity that is zero, nor the gyro's
/// scale from a rate that is.
Linearization linearize_velocity(const GnssFix& fix, const Estimate& x, const BodyMotion& motion,
                                 const Vector3d& earth_rate, const Gravity& gravity, bool still);

/// The receivers of a run.
struct GnssReceivers : MeasurementType<GnssFix> {
  static constexpr std::string_view kName = "gnss";
  static constexpr bool kNumbered = true;
  static constexpr std::array kChannels{MeasurementChannel{.name = "position", .partner = 1},
                                        MeasurementChannel{.name = "velocity", .partner = 0}};
  static int sensors(const FilterOptions& options) { return static_cast<int>(options.gnss.size()); }
  static std::span<const std::vector<GnssFix>> logged(const Log& log) { return log.gnss; }
  static bool repeats(const GnssFix& fix, const GnssFix& before);
  static std::optional<Linearization> linearize(const GnssFix& fix, int sensor, int channel,
                                                const MeasurementContext& context, const Estimate& x);
};

}  // namespace piste
