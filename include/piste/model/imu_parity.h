#pragma once
/// The parities of several IMUs on one body as measurements. Parity k of their outputs is
///
///     p_k = Σ_i L_ki y_i = Σ_i L_ki (s_i u + b_i + d_i) + noise,     u = (û − b̄ − d̄) / (1 + s̄)
///
/// on every axis, for rates and for specific forces, with the errors of the IMUs as core/imu_array.h splits them. s_i u
/// is the effect of the scales of IMU i along its own axes (TurnedScale). The noise of p is uncorrelated with that of
/// the mean û, which the filter mechanizes. Together both have all information of the single IMUs.

#include "piste/core/options.h"
#include "piste/model/measurement.h"

namespace piste {

/// Linearises parity `parity`, from 0, of the gyroscopes or of the accelerometers. Nothing if the fix does not have it.
std::optional<Linearization> linearize_parity(const ParityFix& fix, int parity, TriadMember triad,
                                              const FilterOptions& options, const Estimate& x);

/// The parities of a run.
struct ImuParity : MeasurementType<ParityFix> {
  static constexpr std::string_view kName = "parity";
  static constexpr bool kNumbered = true;
  static constexpr bool kAdapted = false;  // its noise is that of the IMUs, and conditioning has measured it
  static constexpr std::array kChannels{MeasurementChannel{.name = "gyro", .axes = kBodyAxes},
                                        MeasurementChannel{.name = "accel", .axes = kBodyAxes}};
  static int sensors(const FilterOptions& options) { return std::max(0, static_cast<int>(options.imus.size()) - 1); }
  static bool in_use(const FilterOptions& options) { return options.imus.size() > 1; }
  static std::span<const std::vector<ParityFix>> logged(const Log& log) { return log.parity; }
  static std::optional<Linearization> linearize(const ParityFix& fix, int sensor, int channel,
                                                const MeasurementContext& context, const Estimate& x) {
    return linearize_parity(fix, sensor, channel == 0 ? &ImuSensor::gyro : &ImuSensor::accel, context.options, x);
  }
};

}  // namespace piste
