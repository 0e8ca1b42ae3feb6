#pragma once
/// A magnetometer on the body measures the Earth's field, distorted by the iron of its carrier:
///
///     m = (1 + S) R_bn B + R_bn d + h
///
/// where B is the Earth's field along north, east, down, h the hard iron, and d the disturbance by the surroundings (a
/// coloured error). S is the soft iron, with the scales and the misalignment of the sensor: any matrix. Source: Groves
/// 2013, section 6.1.1 and equation 6.9. S d is left out: the estimate of d is mostly noise, and as a factor of S it
/// would pass for information on S (errors in variables). While the iron is unknown the field gives no heading. Motion
/// determines the iron first, wherever another source observes the attitude. All in µT.

#include "piste/core/options.h"
#include "piste/model/measurement.h"

namespace piste {

/// Azimuth [rad], from north towards east, of a vector along the local level.
double azimuth(const Vector3d& field_n);

/// Linearises a magnetometer: three rows, along the axes of the body. `R_wn`: the local level at the body.
Linearization linearize_magnetic_field(const MagneticSample& sample, double sigma, const Estimate& x,
                                       const Matrix3d& R_wn);

/// The magnetometer of the IMU. Near a car or a girder the field is not the Earth's: such samples are outside the gate
/// and rejected, and so are the samples of the 2 s after. They never reset the filter.
struct Magnetometer : MeasurementType<MagneticSample> {
  static constexpr std::string_view kName = "magnetometer";
  static constexpr double kLetGo = 2;  // s
  static constexpr std::array kChannels{
      MeasurementChannel{.name = "", .readmitted = false, .hold = kLetGo, .axes = kBodyAxes}};
  static int sensors(const FilterOptions& options) { return options.magnetometer ? 1 : 0; }
  static bool in_use(const FilterOptions& options) { return options.magnetometer.has_value(); }
  static std::span<const std::vector<MagneticSample>> logged(const Log& log) { return {&log.magnetic, 1}; }
  static std::optional<Linearization> linearize(const MagneticSample& sample, int, int,
                                                const MeasurementContext& context, const Estimate& x) {
    return linearize_magnetic_field(sample, context.options.magnetometer->sigma, x, context.gravity.R_wn);
  }
};

}  // namespace piste
