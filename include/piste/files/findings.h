#pragma once
/// The file `findings.json`, with the errors of one IMU in one run. Equal findings give equal bytes.

#include <string>

#include "piste/condition/alignment.h"
#include "piste/fit/imu_fit.h"

namespace piste {

/// `findings.json`: the members of alignment.json; `convention` and `directions` in words; `phases` as [start, end] in
/// GPS time; under `axes`, for fx fy fz wx wy wz, `rest` (before, after, change) and `run` (bias_only, scale_only,
/// joint, both_noisy, polynomial); and under `matrix`, for accel and gyro, x y z: bias, a row of the gain [ppm], and a
/// row of the g-sensitivity of gyroscopes. Coefficients of a polynomial belong to the powers 0 to order of the signal
/// in the axis' unit, so the coefficient of the first power is a ratio. Every number has its value, formal sigma,
/// standard error for coloured noise, systematic error, effective degrees of freedom and p-value. Every line has its
/// correlation, its variance inflation, and the same as a correction to add. Units are in the names of the members.
/// What does not exist is null.
std::string findings_json(const Findings& findings, const Alignment& alignment);

}  // namespace piste
