#pragma once
/// The non-holonomic constraint of wheels, and the odometer. A vehicle moves along its own axis at the contact point of
/// its rear wheels. For a bicycle that is its rear wheel's, at any lean. An odometer measures the speed there.
///
///     u = R_vb (R_wbᵀ v + ω_eb × l)       0 = u_right + κ u_fwd² ω_down + s_right
///     0 = u_down − d ω_right − (δ f_fwd + φ) u_fwd                odometer = (1 + scale) (u_fwd + s_fwd)
///
/// where R_vb is the mounting, l the contact point in b, ω_eb = ω_ib − R_wbᵀ ω_ie, and s the slip (coloured errors). κ
/// is the slip angle of the tyres per lateral acceleration u_fwd ω_down. A car stands on springs: d is the distance of
/// its pitch axis before the contact point, and δ its dive per forward specific force f. φ is the remainder of that
/// pitch (a coloured error). ω and f with an axis are in v. Source: Groves 2013, section 15.4; Dissanayake et al. 2001.
/// White noise alone would make the covariance too small, as a side-slip lasts for seconds. Without the springs their
/// pitch would pass for a scale of the gyroscopes.
///
/// With the error of estimate.h, R_wbᵀ v changes by R_wbᵀ ν and not with the attitude: a heading that no source
/// observes stays unknown. Rate and force are means over the last samples (RecentMotion), without the vibration of an
/// engine. In Jacobians their expected noise is subtracted: otherwise it would pass for information on the contact
/// point.

#include "piste/core/options.h"
#include "piste/model/measurement.h"

namespace piste {

/// Rate and specific force at the time of a fix in b, and the rate as Jacobians take it.
struct WheelMotion {
  Vector3d rate = Vector3d::Zero(), reference_rate = Vector3d::Zero();
  Vector3d force = Vector3d::Zero();
  double rate_variance = 0, force_variance = 0;  ///< of the white noise in an axis
  Vector3d earth_rate = Vector3d::Zero();        ///< in w
};

/// The axes of a vehicle.
enum class VehicleAxis { kForward, kRight, kDown };

/// Linearises the velocity of the contact point along an axis of the vehicle, with side-slip, along `kRight` with
/// the slip of tyres, and along `kDown` with the springs: one row, 0 − that velocity. The covariance has the noise of
/// rate and force, but not that of constraint or odometer.
Linearization linearize_wheel(VehicleAxis axis, const Estimate& x, const WheelMotion& motion);

/// A moment at which the constraint is applied.
struct VehicleFix {
  double time = 0;
};

/// The constraint. The filter makes its fixes. A body at rest needs none.
struct VehicleConstraint : MeasurementType<VehicleFix> {
  static constexpr std::string_view kName = "vehicle";
  static constexpr bool kAdapted = false;  // its errors are coloured, and stated as such
  static constexpr double kLetGo = 2;      ///< s: a slide may look small before it is over
  static constexpr std::array kChannels{
      MeasurementChannel{.name = "right", .readmitted = false, .hold = kLetGo, .axes = {"right"}},
      MeasurementChannel{.name = "down", .readmitted = false, .hold = kLetGo, .axes = {"down"}}};
  static int sensors(const FilterOptions& options) { return options.vehicle ? 1 : 0; }
  static bool in_use(const FilterOptions& options) { return options.vehicle.has_value(); }
  static std::optional<double> interval(const FilterOptions& options) {
    return options.vehicle ? std::optional(options.vehicle->interval) : std::nullopt;
  }
  static std::optional<Linearization> linearize(const VehicleFix& fix, int sensor, int channel,
                                                const MeasurementContext& context, const Estimate& x);
};

/// The odometer. Unless it is signed it measures the absolute value of the speed.
struct Odometer : MeasurementType<SpeedFix> {
  static constexpr std::string_view kName = "odometer";
  static constexpr std::array kChannels{
      MeasurementChannel{.name = "", .readmitted = false, .hold = VehicleConstraint::kLetGo, .axes = {"forward"}}};
  static int sensors(const FilterOptions& options) { return options.odometer ? 1 : 0; }
  static bool in_use(const FilterOptions& options) { return options.odometer.has_value(); }
  static std::span<const std::vector<SpeedFix>> logged(const Log& log) { return {&log.speed, 1}; }
  static std::optional<Linearization> linearize(const SpeedFix& fix, int sensor, int channel,
                                                const MeasurementContext& context, const Estimate& x);
};

}  // namespace piste
