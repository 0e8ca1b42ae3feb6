#pragma once
/// Converts fits into KnownErrors, which can be subtracted from the IMU's samples. The order of axes is fx fy fz wx wy
/// wz. An axis or triad without a fit has no errors.

#include <array>
#include <optional>

#include "piste/fit/imu_fit.h"
#include "piste/model/known_errors.h"

namespace piste {

/// Bias and scale of each axis. A bias alone is a line of scale 0.
KnownErrors errors_of_lines(const std::array<std::optional<BiasScale>, 6>& lines);

/// Coefficients c_0 to c_3 of each axis.
KnownErrors errors_of_polynomials(const std::array<std::optional<PolynomialFit>, 6>& polynomials);

/// Bias and gain of both triads, and the g-sensitivity of the gyroscopes where it was fitted.
KnownErrors errors_of_matrices(const std::optional<MatrixFit>& accel, const std::optional<MatrixFit>& gyro);

}  // namespace piste
