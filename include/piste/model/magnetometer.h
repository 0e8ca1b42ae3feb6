#pragma once
/// Heading from a magnetometer: with the right attitude, the azimuth of the measured field in w is the declination.

#include "piste/model/measurement.h"

namespace piste {

/// Azimuth [rad], from w's north towards east, of a field in body axes.
double magnetic_azimuth(const Quaterniond& q_wb, const Vector3d& field_b);

/// Linearises a magnetic heading. One row: declination − azimuth, wrapped to ±π. `sigma` [rad].
Linearization linearize_magnetic_heading(const Vector3d& field_b, double declination, double sigma, const Estimate& x);

/// The magnetometer of the IMU.
struct Magnetometer : MeasurementType<MagneticSample> {
  static constexpr std::string_view kName = "magnetic";
  static constexpr std::array kChannels{MeasurementChannel{}};
  static bool in_use(const FilterOptions& options) { return options.magnetic_sigma > 0; }
  static std::span<const std::vector<MagneticSample>> logged(const Log& log) { return {&log.magnetic, 1}; }
  static std::optional<Linearization> linearize(const MagneticSample& sample, int, int,
                                                const MeasurementContext& context, const Estimate& x) {
    return linearize_magnetic_heading(sample.field, context.options.declination, context.options.magnetic_sigma, x);
  }
};

}  // namespace piste
