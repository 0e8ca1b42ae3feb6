#pragma once
/// Attitude of a reference IMU, seen through the boresight.
///
///     R_wr = Exp(n) Exp(a) R_wb (Exp(d) R_rb)ᵀ        residual z = Log(R_wr,measured (Exp(â) R̂_wb (Exp(d̂) R̂_rb)ᵀ)ᵀ)
///
/// a coloured error of the reference, n its white error, both rotation vectors in w; d what a mount that gives adds to
/// the boresight, rotation vector in r. The boresight stands on the right of R_wb, on the body's side (the article
/// prints the other). Moving the prediction by Exp(η) from the left changes z by −J_r⁻¹(z) η, whence the Jacobians.

#include "piste/core/options.h"
#include "piste/model/measurement.h"

namespace piste {

/// `white`: what part of the fix's sigma is white noise, along w; the attitude_drift block carries the rest.
///
/// `after`: what the estimate becomes by this fix, to first order; the Jacobians are then those half-way. A fix tells
/// attitude and boresight together, and only a body that turns tells them apart. With the Jacobians at `x` the gyro's
/// noise, which the fix takes out again, is such a turn, and at rest both would seem known: half-way, what the fix
/// leaves unknown stays unknown through correction and reset, to second order.
Linearization linearize_attitude(const AttitudeFix& fix, const Vector3d& white, const Estimate& x,
                                 const Estimate* after = nullptr);

/// The reference attitudes of a run.
struct ReferenceAttitudes : MeasurementType<AttitudeFix> {
  static constexpr std::string_view kName = "attitude";
  static constexpr bool kNumbered = true;
  static constexpr std::array kChannels{MeasurementChannel{}};
  static int sensors(const FilterOptions& options) { return static_cast<int>(options.attitude.size()); }
  static std::span<const std::vector<AttitudeFix>> logged(const Log& log) { return log.attitude; }
  static std::optional<Linearization> linearize(const AttitudeFix& fix, int sensor, int channel,
                                                const MeasurementContext& context, const Estimate& x,
                                                const Estimate* after = nullptr);
};

}  // namespace piste
