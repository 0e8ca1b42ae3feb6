#pragma once
/// Known errors of an IMU, and how to remove them from its samples.
///
///     measured = (I + gain) true + bias + quadratic true² + cubic true³      per triad, powers axis by axis
///     gyroscopes besides: + g_sensitivity f                                  f the true specific force
///
/// The diagonal of the gain is the scale. Its other elements are misalignment and cross-axis sensitivity.

#include "piste/core/log.h"
#include "piste/math/so3.h"

namespace piste {

/// Known errors of three gyroscopes or three accelerometers, SI and radians. All zero: no errors.
struct KnownTriadErrors {
  Vector3d bias = Vector3d::Zero();
  Matrix3d gain = Matrix3d::Zero();
  Vector3d quadratic = Vector3d::Zero(), cubic = Vector3d::Zero();
};

struct KnownErrors {
  KnownTriadErrors gyro, accel;
  Matrix3d g_sensitivity = Matrix3d::Zero();  ///< rad/s of each gyroscope per m/s² along each axis
};

/// The sample with its errors removed. Solves the equation above for the true rate and force by Newton's method. Both
/// are taken as constant over the interval of the sample. All else of the sample is kept.
/// @pre interval > 0, and the equation has one solution near the sample. A cubic has several where its slope changes
/// sign, which is far beyond the signals that it was fitted to.
ImuSample corrected(const ImuSample& measured, const KnownErrors& errors);

}  // namespace piste
