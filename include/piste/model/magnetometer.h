#pragma once
/// Heading from a magnetometer: with the right attitude, the azimuth of the measured field in the local level is the
/// declination.

#include "piste/model/measurement.h"

namespace piste {

/// Azimuth [rad], from north towards east, of a field in body axes.
double magnetic_azimuth(const Quaterniond& q_nb, const Vector3d& field_b);

/// Linearises a magnetic heading. One row: declination − azimuth, wrapped to ±π. `sigma` [rad]. `R_wn`: the
/// local level at the body.
Linearization linearize_magnetic_heading(const Vector3d& field_b, double declination, double sigma, const Estimate& x,
                                         const Matrix3d& R_wn = Matrix3d::Identity());

/// The magnetometer of the IMU.
struct Magnetometer : MeasurementType<MagneticSample> {
  static constexpr std::string_view kName = "magnetic";
  static constexpr std::array kChannels{MeasurementChannel{}};
  static bool in_use(const FilterOptions& options) { return options.magnetic_sigma > 0; }
  static std::span<const std::vector<MagneticSample>> logged(const Log& log) { return {&log.magnetic, 1}; }
  static std::optional<Linearization> linearize(const MagneticSample& sample, int, int,
                                                const MeasurementContext& context, const Estimate& x) {
    return linearize_magnetic_heading(sample.field, context.options.declination, context.options.magnetic_sigma, x,
                                      context.gravity.R_wn);
  }
};

}  // namespace piste
