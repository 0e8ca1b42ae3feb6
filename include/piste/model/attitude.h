#pragma once
/// The attitude of a reference IMU as a measurement of the body's attitude and of the boresight.
///
///     R_wr = Exp(R_wn e) Exp(R_wn a) B (Exp(d) R_rb)ᵀ
///     residual z = Log(R_wr,measured (Exp(R_wn â) B̂ (Exp(d̂) R̂_rb)ᵀ)ᵀ)
///     B = Exp(ω_ie τ) R_wb Exp(−ω τ)
///
/// where B is the body's attitude τ before the estimate, with τ as in gnss.h: 0 unless the delay differs from the one
/// by which the fix was given its place. ω is the rate at the time of the estimate. In the derivative by the delay it
/// is reduced by what its noise explains, and further where the delay is uncertain by much of a vibration's period. A
/// mean over samples would lose the vibration, by which a delay is observable first. a is the coloured error of the
/// reference and e its white error, both rotation vectors along the local level n. d is the change of the boresight on
/// a flexible mount, a rotation vector in r. The boresight stands on the right of R_wb, on the body's side (the article
/// prints it on the other side). Jacobians: a rotation of the prediction by Exp(η) from the left changes z by −J_r⁻¹(z)
/// η.

#include "piste/core/options.h"
#include "piste/model/measurement.h"

namespace piste {

/// Rotation of the body near the time of a fix, and the time by which the fix belongs before the estimate.
struct Turning {
  Vector3d earth_rate = Vector3d::Zero();
  Vector3d rate = Vector3d::Zero();         ///< ω, in b
  Lag lag = {};                             ///< at rest without a block: the rate is noise
  Vector3d rate_change = Vector3d::Zero();  ///< the derivative of ω [rad/s²]
  double rate_variance = 0;                 ///< of the white noise of ω in an axis
  Vector3d force = Vector3d::Zero();        ///< f, by which gyroscopes may be wrong
};

/// Linearises an attitude fix at the estimate `x`.
///
/// `white`: the fraction of the fix's sigma that is white noise, along the local level, of which `R_wn` is the
/// rotation. The block attitude_drift has the remainder.
///
/// `after`: the estimate after this fix, to first order. If it is given, the Jacobians are taken half-way between `x`
/// and `after`, for which `turning_after` is as `turning` for `x`. The reason: one fix determines only the sum of
/// attitude and boresight, and only a body that turns separates them. The gyroscope's noise between two fixes looks
/// like such a turn until the fix removes it. With the Jacobians at `x`, attitude and boresight would therefore seem
/// observable even at rest. With those half-way, what the fix leaves unknown stays unknown through correction and
/// reset, to second order.
Linearization linearize_attitude(const AttitudeFix& fix, const Vector3d& white, const Estimate& x,
                                 const Matrix3d& R_wn = Matrix3d::Identity(), const Estimate* after = nullptr,
                                 const Turning& turning = {}, const Turning& turning_after = {});

/// The reference attitudes of a run.
struct ReferenceAttitudes : MeasurementType<AttitudeFix> {
  static constexpr std::string_view kName = "attitude";
  static constexpr bool kNumbered = true;
  static constexpr std::array kChannels{MeasurementChannel{}};
  static int sensors(const FilterOptions& options) { return static_cast<int>(options.attitude.size()); }
  static std::span<const std::vector<AttitudeFix>> logged(const Log& log) { return log.attitude; }
  static FixDelay delay(const FilterOptions& options, const StateLayout& layout, int sensor, int channel,
                        const Estimate& x, double elapsed);
  static std::optional<Linearization> linearize(const AttitudeFix& fix, int sensor, int channel,
                                                const MeasurementContext& context, const Estimate& x,
                                                const Estimate* after = nullptr);
};

}  // namespace piste
