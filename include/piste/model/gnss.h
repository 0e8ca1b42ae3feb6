#pragma once
/// GNSS position and velocity as measurements. The antenna is on a lever arm, the fix may be late, and the position may
/// have a coloured error.
///
///     y_p = p − v τ + a τ²/2 + E R C l + R_wn d     y_v = v − a τ + R C (ω × l) − ω_ie × R l
///     E = Exp(ω_ie τ)   C = Exp(−ω̄ τ)   ω = ω_ib   a = R f̄ + g(p) − 2 ω_ie × v
///
/// where l is the lever arm, and τ the time by which position or velocity belong before the estimate. d is the slow
/// error along the local level n, in m or as a state times the stated sigmas (PositionDrift). The filter compares a
/// late fix with the estimate at the time of the fix, by the known or estimated delay. τ is then 0, and only its
/// derivative counts. It is not 0 while the estimated delay still changes, nor in real time, where that estimate is
/// past. ω̄ and f̄ are means over the last samples (RecentMotion). For an instantaneous velocity f̄ is the present
/// force instead: a mean lags a vibration, all of which such a velocity shows. A velocity that is 20 ms later than its
/// position is itself taken for a mean. The velocity has no term of second order, as that would need the jerk: it
/// counts as noise instead. Jacobians are with respect to the error of estimate.h.
///
/// The sigmas of a fix are along n, and R_wn is that of `gravity`. Rows are along w. A velocity without down has two
/// rows instead, along north and east of n.

#include "piste/core/options.h"
#include "piste/model/measurement.h"

namespace piste {

/// Rate and force about the time of a fix.
struct AntennaMotion {
  BodyMotion now;                            ///< at the time of the estimate
  Vector3d reference_rate = now.rate;        ///< in Jacobians (MeasurementContext::rate_without_noise)
  double observed_noise = 0;                 ///< in that rate (MeasurementContext::observed_noise)
  BodyMotion mean = {};                      ///< ω̄ and f̄ shortly before
  Vector3d force_change = Vector3d::Zero();  ///< of R f in w, as a mean, in b [m/s³]
  double force_variance = 0;                 ///< of the white noise of f̄ in an axis
  /// ω̄ and f̄ over the lag of a fix that comes late; `mean` stands for them where they are not known.
  std::optional<BodyMotion> lagged = std::nullopt;

  const BodyMotion& over_lag() const { return lagged ? *lagged : mean; }
};

/// Linearises the position of a fix. Its white sigma is the total less that of `drift`, sqrt(total² − drift²). With a
/// drift in m it is at least 10 % of the total. The lever arm is that of the estimate. `receiver`: the receiver whose
/// block the drift is.
Linearization linearize_position(const GnssFix& fix, const std::optional<PositionDrift>& drift, const Estimate& x,
                                 const AntennaMotion& motion, const Vector3d& earth_rate, const Gravity& gravity,
                                 const Lag& lag = {}, bool still = false, int receiver = 0);

/// The slow error of a fix along n [m], as the estimate has it; 0 if the receiver has none.
Vector3d slow_error(const GnssFix& fix, const std::optional<PositionDrift>& drift, int receiver, const Estimate& x);

/// Linearises the velocity of a fix. It has two rows, north and east, if down was not measured. Its noise is that of
/// the fix and that of the gyroscopes, which turns the lever arm. Jacobians by the lever arm and the gyroscopes have
/// `reference_rate`. `still`: the body is at rest; velocity and acceleration are then taken as zero in the Jacobians,
/// so that their noise gives no false information on heading and delay.
/// @pre `fix.velocity` is there.
Linearization linearize_velocity(const GnssFix& fix, const Estimate& x, const AntennaMotion& motion,
                                 const Vector3d& earth_rate, const Gravity& gravity, bool still, const Lag& lag = {});

/// Linearises a velocity that is the mean over `averaging` seconds: the difference of the antenna's places at the end
/// and at the beginning, over that time,
///
///     y = (y_p(τ) − y_p(τ + T)) / T
///
/// with y_p as above, without its slow error. `end`, `begin`: the motion over τ, and over τ + T. `lag`: of the end of
/// the mean. @pre `fix.velocity` is there, `averaging` > 0.
Linearization linearize_mean_velocity(const GnssFix& fix, double averaging, const Estimate& x, const AntennaMotion& end,
                                      const AntennaMotion& begin, const Vector3d& earth_rate, const Gravity& gravity,
                                      bool still, const Lag& lag);

/// The receivers of a run. The delays of the first receiver are estimated; their changes from the configured values are
/// added to the delays of all. Where the delay of the positions is estimated and that of the velocities is not, the
/// velocities follow it.
struct GnssReceivers : MeasurementType<GnssFix> {
  static constexpr std::string_view kName = "gnss";
  static constexpr bool kNumbered = true;
  static constexpr std::array kChannels{MeasurementChannel{.name = "position", .partner = 1},
                                        MeasurementChannel{.name = "velocity", .partner = 0}};
  static int sensors(const FilterOptions& options) { return static_cast<int>(options.gnss.size()); }
  static std::span<const std::vector<GnssFix>> logged(const Log& log) { return log.gnss; }
  static FixDelay delay(const FilterOptions& options, const StateLayout& layout, int sensor, int channel,
                        const Estimate& x, double elapsed);
  static bool repeats(const GnssFix& fix, const GnssFix& before);
  static std::optional<Linearization> linearize(const GnssFix& fix, int sensor, int channel,
                                                const MeasurementContext& context, const Estimate& x);
};

}  // namespace piste
