#pragma once
/// What IMUs of a class are sold with, for errors that neither a record at rest nor the innovations of a run show.

#include <string_view>

#include "piste/core/sensor.h"

namespace piste {

/// A class of IMUs. The noise densities are the largest of the class, and the errors are 1-sigma. Sources, by data
/// sheets: LN-200, 0.1 mrad between axes, and STIM300, 7 deg/h/g; ADIS16488A, 0.05 deg between axes (870 ppm) and 0.009
/// deg/s/g; MPU-9250, at most 2 % cross-axis sensitivity, and MPU-6050, 0.1 deg/s/g. Sixteen calibrated MEMS-IMUs on a
/// board had 520 ppm (accelerometers) and 1500 ppm (gyroscopes); a consumer's unit is not calibrated.
struct SensorClass {
  std::string_view name;
  double gyro_noise, accel_noise;  ///< [rad/s/√Hz], [m/s²/√Hz]
  double cross_axis;               ///< of each element, as a ratio
  double gyro_g_sensitivity;       ///< of each element [rad/s per m/s²]
};

/// The class of an IMU: the best of which both of its noises are within the bounds.
/// Example: 0.05 deg/s/√Hz and 200 µg/√Hz is a consumer's.
const SensorClass& class_of(const ImuSensor& sensor);

/// The sensor with the cross-axis errors and the g-sensitivity of its class, where it states none.
ImuSensor with_errors_of_class(ImuSensor sensor);

}  // namespace piste
