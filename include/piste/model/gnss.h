#pragma once
/// GNSS position and velocity as measurements. The antenna is on a lever arm, the fix may be late, and the position may
/// have a coloured error.
///
///     y_p = p + R l − v_a τ + d          y_v = v_a − a τ
///     v_a = v + R (ω × l) − ω_ie × R l   ω = ω_ib, a ≈ R f + g − 2 ω_ie × v
///
/// where l is the lever arm, τ the delay (a fix with time t was measured at t − τ) and d the coloured error. Jacobians
/// are with respect to the error of estimate.h.

#include "piste/core/options.h"
#include "piste/model/measurement.h"

namespace piste {

/// Linearises the position of a fix. Its white sigma is the total less that of `drift`, sqrt(total² − drift²), and at
/// least 10 % of the total. The lever arm is that of the estimate.
Linearization linearize_position(const GnssFix& fix, const std::optional<GaussMarkov>& drift, const Estimate& x,
                                 const BodyMotion& motion, const Vector3d& earth_rate, const Gravity& gravity);

/// Linearises the velocity of a fix. It has two rows if down was not measured. Its noise is that of the fix and that of
/// the gyroscopes, which turns the lever arm. `still`: the body is at rest; velocity and rate are then taken as zero in
/// the Jacobians, so that their noise gives no false information on heading and scale. @pre `fix.velocity` is there.
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
