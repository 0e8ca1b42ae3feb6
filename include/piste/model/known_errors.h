#pragma once
/// Errors of an IMU that are known, and their removal: the map from measured to true.
///
///     measured = (I + gain) true + bias + quadratic true² + cubic true³      per triad, powers axis by axis
///     gyroscopes besides: + g_sensitivity f                                  f the true specific force
///
/// The diagonal of the gain is the scale; off it are misalignment and cross-axis sensitivity.

#include "piste/core/log.h"
#include "piste/math/so3.h"

namespace piste {

/// SI and radians; all zero is a triad without errors.
struct KnownTriadErrors {
  Vector3d bias = Vector3d::Zero();
  Matrix3d gain = Matrix3d::Zero();
  Vector3d quadratic = Vector3d::Zero(), cubic = Vector3d::Zero();
};

struct KnownErrors {
  KnownTriadErrors gyro, accel;
  Matrix3d g_sensitivity = Matrix3d::Zero();  ///< rad/s of each gyroscope per m/s² along each axis
};

/// True increments of a sample that `errors` made, by Newton's method on the means over its interval: of mean signals,
/// so powers of what changes within an interval are those of its mean. All else of the sample is kept.
/// @pre interval > 0; the map is one to one about the sample: a polynomial is not where its slope changes sign, which a
/// cubic does far beyond the signals that it was fitted to.
ImuSample corrected(const ImuSample& measured, const KnownErrors& errors);

}  // namespace piste
